"""Photographs of a painted ball or of a flat sample as measurements: what a goniometer is for those who have a camera
and a lamp.

A `description` says where camera, sample and lamps were, and which file is which; `pictures` are its files as light;
`rig` has what balls and flat samples share. `ball` makes samples of them, `flat` maps. `capture` has the scene of a
description, `report` what is to be said of what was measured.
"""
