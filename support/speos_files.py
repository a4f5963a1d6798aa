"""Speos files made for tests."""

import numpy as np


def made(values=None, incidences=(15, 40), rotations=(0,), polar=(0, 20, 40, 60, 80), azimuths=range(0, 361, 60),
         at=(15, 0), bands=((350, 20), (850, 20)), is_bsdf=True, flags=(1, 0), description="Made for a test", end="\n"):
    """The text of a file: values (rotation x incidence, polar, azimuth), or 1, 2, 3 ..."""
    polar, azimuths = list(polar), list(azimuths)
    shape = len(rotations) * len(incidences), len(polar), len(azimuths)
    values = np.arange(1.0, np.prod(shape) + 1).reshape(shape) if values is None else np.asarray(values)
    each = [len(incidences), "\t".join(map(str, incidences))] * len(rotations)
    lists = [len(rotations), "\t".join(map(str, rotations)), *each]
    spectrum = [f"{at[0]}\t{at[1]}", "", len(bands), *(f"{nm}\t{percent}" for nm, percent in bands)]
    lines = ["OPTIS - Anisotropic BSDF surface file v8.0", 0, "Comment", len(description), description, "0\t1\t0",
             "\t".join(map(str, flags)), int(is_bsdf), *lists * sum(flags), *spectrum * sum(flags)]
    for table in values:
        lines += [f"{len(polar)} {len(azimuths)}", "\t" + "\t".join(map(str, azimuths)),
                  *(f"{angle}\t" + "\t".join(map(repr, map(float, row)))
                    for angle, row in zip(polar, table, strict=True))]
    return end.join([*map(str, lines), "End of file", ""])
