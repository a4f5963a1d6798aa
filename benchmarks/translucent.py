"""What of translucent materials is worked out by photons: how much farther the light of Cycles' walks leaves, and how
far its walks with other radii then are from the truth.

`--factors` prints the table of `fitter.optics.subsurface`, in some ten minutes. Otherwise it prints, for each material
of the library and each channel, what leaves again and the radii within which half and nine tenths of that do, below a
surface, and by the walk with the inputs that the extension gives it.
"""

import argparse
from collections.abc import Iterator

import numpy as np

from fitter.model import published
from fitter.optics import subsurface
from fitter.optics.subsurface import Subsurface
from support import photons

SHARES = 0.5, 0.9


def factor(scattered: float, index: float) -> float:
    """The factor at a single scattering albedo and an index."""
    count = 200_000 if scattered > 0.9 else 400_000
    entry = float(np.sqrt(index))
    albedo = subsurface.multiple_scattering_albedo(scattered, index)
    walked = subsurface.bisect(lambda a: subsurface.walk_albedo(a, entry), albedo)
    truth, walk = photons.radii(scattered, index, count), photons.cycles_radii(walked, entry, count)
    return float(np.exp(np.mean([np.log(photons.quantile(walk, each) / photons.quantile(truth, each))
                                 for each in SHARES])))


def compared(medium: Subsurface, count: int) -> Iterator[tuple[list[float], list[float]]]:
    """Of each channel: albedo, and both radii in mm, below a surface and by Cycles' walk."""
    walk = medium.walk
    both = zip(medium.single_scattering_albedo, medium.mean_free_path, strict=True)
    for channel, (scattered, path) in enumerate(both):
        truth = photons.radii(scattered, medium.index, count)
        walks = photons.cycles_radii(subsurface.color_to_single_scattering(walk.color[channel]), walk.entry, count)
        yield tuple([float(found[1].sum()) + more, *(length * photons.quantile(found, each) for each in SHARES)]
                    for found, length, more in ((truth, path, 0.0),
                                                (walks, walk.radius[channel] / (4 * np.pi), walk.rest[channel])))


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--factors", action="store_true")
    parser.add_argument("--photons", type=int, default=60_000)
    options = parser.parse_args()
    if options.factors:
        for index in subsurface.INDICES_OF_FACTOR:
            row = [factor(1 - absorbed ** 2, index) for absorbed in subsurface.ABSORBED]
            print(f"    [{', '.join(f'{each:.3f}' for each in row)}],", flush=True)
        return
    print("| Material | Channel | Albedo | Walk | Median, mm | Walk | 90 %, mm | Walk |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for material in published.translucent():
        if not options.names or material.name in options.names:
            for channel, pairs in zip("RGB", compared(material.model.subsurface, options.photons), strict=True):
                cells = [f"{number:.3g}" for pair in zip(*pairs, strict=True) for number in pair]
                print(f"| {material.label} | {channel} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
