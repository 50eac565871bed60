"""Kinematics, inertia and the momentum-conserving free-floating motion."""
