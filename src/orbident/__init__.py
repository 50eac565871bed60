"""Identification of free-flying space manipulators."""
