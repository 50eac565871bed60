"""What acts on a flying robot from outside, computed from the flight itself."""
