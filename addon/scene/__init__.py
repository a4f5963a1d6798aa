"""A scene, as the shader needs to know it: lamps, instanced lamps, small bright places of the world, and the device.

This is the lowest layer of the add-on. It imports nothing of the others; of `fitter` only the number of lamps that a
shader takes.
"""
