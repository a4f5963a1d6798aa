"""Measured materials: what they are in a .blend, how they are rendered, and what in a scene changes their look.

It fits nothing: results of `work` are passed in. Slices tell it about mixes (`mixing`), edits (`edits`) and findings
(`checks`).
"""
