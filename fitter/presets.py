"""Named choices of what a fit may cost: keyword arguments for `fit`."""

PRESETS = {
    # Kameya and Lewis 2002, the compressed fit that they recommend: (4, 6, 95)
    "Paper": {"diffuse_level": 4, "specular_level": 6, "compression": 95.0},
    # a quarter of the storage, for look development
    "Draft": {"diffuse_level": 3, "specular_level": 5, "compression": 90.0},
    # what a scene is rendered with
    "Standard": {"diffuse_level": 4, "specular_level": 6, "compression": 95.0},
    # narrow highlights: a finer lattice for both parts
    "Reference": {"diffuse_level": 5, "specular_level": 7, "compression": 95.0},
}
