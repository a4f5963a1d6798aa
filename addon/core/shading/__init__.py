"""Building a material of a fit: bytecode, node group, closure nodes, mixes, exported surface; how it is rendered.

`material` is the way in. Of lamps it knows the group that holds them; libraries, checks and slices import it.
"""
