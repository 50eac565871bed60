"""The kinematics and dynamics of one state after the other, in compiled loops."""
