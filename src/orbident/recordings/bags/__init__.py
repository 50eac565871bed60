"""ROS bags and MCAP files into recordings, through a topic map."""
