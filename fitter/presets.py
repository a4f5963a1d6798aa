"""Named choices of what a fit may cost: keyword arguments for `fit`."""

PRESETS = {
    # exactly the method of Kameya and Lewis 2002, with the compressed fit that they recommend: (4, 6, 95)
    "Paper": {"diffuse_level": 4, "specular_level": 6, "compression": 95.0, "method": "mba"},
    # for look development: at most 6 KiB a channel
    "Draft": {"diffuse_level": 3, "specular_level": 5, "compression": 99.0, "method": "kriging"},
    # what a scene is rendered with: at most 16 KiB a channel
    "Standard": {"diffuse_level": 4, "specular_level": 6, "compression": 99.75, "method": "kriging"},
    # every sample as it was measured, the narrowest highlights included
    "Reference": {"diffuse_level": 5, "specular_level": 7, "compression": 99.8, "method": "kriging"},
}
