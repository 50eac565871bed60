"""Samples from a recording: screening, clocks, smoothing, fusion of attitudes."""
