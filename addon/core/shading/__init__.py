"""Building a material of a fit: bytecode, node group, closure nodes, mixes, exported surface; how it is rendered.

`material` is the way in. It has `lamps` write those of the scene into each new group; libraries, checks and slices
import it.
"""
