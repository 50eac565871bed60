"""Trajectories that excite."""
