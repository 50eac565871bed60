"""Exciting trajectories: what makes one good, what limits it, and the search."""
