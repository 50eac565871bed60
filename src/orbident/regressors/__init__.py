"""What is linear in the inertial parameters, and its minimal sets."""
