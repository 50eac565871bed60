"""Robots in files of other tools: each becomes links and joints of a URDF."""
