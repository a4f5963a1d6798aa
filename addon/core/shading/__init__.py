"""Building a material of a fit: bytecode, node group, closure nodes, mixes, exported surface; how it is rendered.

`material` is the way in: libraries, checks and slices import it. It knows no lamps: `lamps` follows each new group
(`blender/followers`).
"""
