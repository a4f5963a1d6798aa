"""Photographs of a painted ball as measurements: what a goniometer is for those who have a camera and a lamp.

`ball` says what each pixel measures, `samples` gathers several photographs, `light` makes radiance of exposures,
`scale` finds the lamp's intensity, `ball_finding` and `chrome` where ball and lamp are, `coverage` what is missing,
`ball_advice` which lamp is next, and `setup` reads all of it from files.
"""
