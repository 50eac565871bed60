"""Rotations and cross products: geometry, no model."""
