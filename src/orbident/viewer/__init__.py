"""A page in the browser on which a robot moves."""
