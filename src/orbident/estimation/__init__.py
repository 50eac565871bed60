"""Estimation of parameters from recordings."""
