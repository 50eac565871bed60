"""Motions of a robot, free floating and flying, and what its sensors show of them."""
