"""The results in tables: for how many materials the presets are truer than what is published for them, and medians."""

import math
from statistics import median

from support.evidence import show as show_text
from support.evidence import show_table

from ..harness.running import Bench, ratio
from . import judging, sheet
from .materials import FAMILIES, MICROFACET, NEURAL, TURNED

JUDGED_BY = {"samples_cube_root_rmse": "at the samples", "clipped_cube_root_rmse": "negative ones as 0",
             "between_cube_root_rmse": "between them", "mae": "in the picture"}
RIVALS = {"RGL": (NEURAL, TURNED), "MERL": (MICROFACET,)}
LIMIT = 16 << 10            # bytes a channel
_HEADS = {f"{place}_{kind}": f"{label}, {place}" for place in judging.PLACES
          for kind, label in (("rmse", "RMSE"), ("cube_root_rmse", "cube root"))} | {
    "psnr": "PSNR", "mae": "MAE", "flip": "FLIP", "delta_e_itp": "Delta E ITP"}


def ratios(records, family, own, error):
    """The preset's error over the least of the rivals', by material; infinite where the preset failed."""
    found = {record["name"]: ratio(record["models"], own, RIVALS[family], error)
             for record in records if record["family"] == family}
    return {name: each for name, each in found.items() if not math.isnan(each)}


def show(results):
    """Print for how many materials the presets are below their rivals, and medians of the errors."""
    records = results["materials"]
    rows = []
    for family in FAMILIES:
        for own in ("Draft", "Standard", "Reference"):
            found = [ratios(records, family, own, error) for error in JUDGED_BY]
            if found[0]:
                behind = sorted(((each, name) for name, each in found[-1].items() if each > 1), reverse=True)
                rows.append((family, " or ".join(RIVALS[family]), own, *(
                    f"{sum(each < 1 for each in of.values())} of {len(of)}" for of in found),
                    ", ".join(f"{name} {each:.2f}" for each, name in behind) or "nowhere"))
    show_table("dense-rivals", ("set", "rival", "preset", *(f"smaller {place}" for place in JUDGED_BY.values()),
                                "larger in the picture, times"), rows)
    show_table("dense-medians", ("set", "model", "bytes", *_HEADS.values()), _medians(records))
    sizes = [record["models"]["Standard"]["bytes"] / record["channels"] for record in records
             if record["models"]["Standard"]["bytes"]]
    if sizes:
        show_text("dense-bytes", f"{sum(size <= LIMIT for size in sizes)} of {len(sizes)}")


def _medians(records):
    """Size against error: medians over the materials of a family, by model, the smallest first."""
    for family in FAMILIES:
        of_family = [record for record in records if record["family"] == family]
        names = dict.fromkeys(name for record in of_family for name in record["models"])
        for name in sorted(names, key=lambda name: _median(of_family, name, "bytes") or 0):
            yield family, name, round(_median(of_family, name, "bytes") or 0), *(
                _median(of_family, name, error) for error in _HEADS)


def _median(records, name, key):
    found = [record["models"][name][key] for record in records
             if name in record["models"] and record["models"][name][key] is not None]
    return median(found) if found else None


# here, and not in `__main__`, for worker processes import it
BENCH = Bench("dense", "materials", judging.judge, "models", "samples_cube_root_rmse", show, sheet.draw,
              ("support/merl_files.py", "benchmarks/dense"))
