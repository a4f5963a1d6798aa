"""Building a material of a fit: bytecode, node group, closure nodes, mixes, exported surface; how it is rendered."""
