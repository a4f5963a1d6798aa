"""How much farther the light of Cycles' random walks leaves a translucent material than that of photons does.

``python -m benchmarks.translucent`` prints the table of `fitter.optics.subsurface`, in some ten minutes.
"""

import numpy as np

from fitter.optics import subsurface
from support import photons


def factor(scattered: float, index: float) -> float:
    """The factor at a single scattering albedo and an index."""
    count = 200_000 if scattered > 0.9 else 400_000
    entry = float(np.sqrt(index))
    albedo = subsurface.multiple_scattering_albedo(scattered, index)
    walked = subsurface.bisect(lambda a: subsurface.walk_albedo(a, entry), albedo)
    truth, walk = photons.radii(scattered, index, count), photons.cycles_radii(walked, entry, count)
    return float(np.exp(np.mean([np.log(photons.quantile(walk, each) / photons.quantile(truth, each))
                                 for each in photons.SHARES])))


def main() -> None:
    for index in subsurface.INDICES_OF_FACTOR:
        row = [factor(1 - absorbed ** 2, index) for absorbed in subsurface.ABSORBED]
        print(f"    [{', '.join(f'{each:.3f}' for each in row)}],", flush=True)


if __name__ == "__main__":
    main()
