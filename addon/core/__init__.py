"""Measured materials: what they are in a .blend, how they are rendered, and what in a scene changes their look.

Rooms, from low to high: `blender`, `storage`, `lamps`, `shading`, `libraries`; then `checks` and `preferences`. No room
fits measurements: results of `work` are passed in. (Only scripts that make a node group of a fit have its closures
found here, by `shading.node_group.make`.) Slices tell of mixes (`shading.mixing`), edits (`storage.edits`) and findings
(`checks`).
"""
