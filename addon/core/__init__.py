"""Measured materials: what they are in a .blend, how they are rendered, and what in a scene changes their look.

Rooms, from low to high: `blender`, `storage`, `lamps`, `shading`, `libraries`; then `checks` and `preferences`. None
fits measurements: results of `work` are passed in.
"""
