"""Zemax files made for tests."""

import numpy as np


def made(values=None, incidences=(30, 60), azimuths=(0, 90, 180), radials=(0, 30, 40), gap="\t", end="\n",
         rotations=(0,), **words):
    """The text of a file: values (channels, rotation x incidence, azimuth, radial), or 1, 2, 3 ..."""
    shape = 1, len(rotations) * len(incidences), len(azimuths), len(radials)
    values = np.arange(1.0, np.prod(shape) + 1).reshape(shape) if values is None else np.asarray(values)
    words = {"Source": "Measured", "Symmetry": "PlaneSymmetrical", "SpectralContent": "Monochrome",
             "ScatterType": "BRDF"} | words
    lines = ["# Sample: made", *(f"{keyword}{gap}{word}" for keyword, word in words.items())]
    for keyword, angles in (("SampleRotation", rotations), ("AngleOfIncidence", incidences),
                            ("ScatterAzimuth", azimuths), ("ScatterRadial", radials)):
        lines += [f"{keyword}{gap}{len(angles)}", gap.join(map(str, angles)) + gap]
    for channel in values:
        lines += ["", "Monochrome", "DataBegin"]
        for table in channel:
            lines += ["TIS 0.5", *(gap.join(map(str, row)) for row in table)]
        lines.append("DataEnd")
    return end.join(lines) + end
