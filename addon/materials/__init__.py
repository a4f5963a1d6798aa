"""Measured materials: their settings, the compiled shader in its node group, and what in a scene changes their look.

It imports `scene`, whose lamp group the shaders read, and the shared modules. It fits nothing: outcomes of `jobs.tasks`
are passed in.
"""
