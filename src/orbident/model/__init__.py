"""The robot as equations: kinematics, momentum, inertia, minimal sets, dynamics."""
