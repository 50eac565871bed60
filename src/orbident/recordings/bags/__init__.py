"""ROS bags and MCAP files: their topics, and a stream of messages."""
