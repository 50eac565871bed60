"""What a robot is: plain frozen data, and the readers that make it."""
