"""Estimation sample by sample, and the detection of changes."""
