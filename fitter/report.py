"""``python -m fitter report``: what presets and levels make of measurements, side by side, as a table and as JSON."""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .errors import printable
from .formats import list_samples, load
from .methods import fit
from .methods.presets import PRESETS
from .model.fit import Fit, notation
from .quality import cross_validation
from .quality.metrics import error_metrics
from .samples import Samples, subset
from .storage.files import replace_file, strip_folders

MANY = 2000                 # samples: of more, one fold of the five is held out
COLUMNS = {"fit": "", "bytes": ",", "rmse": ".4g", "mae": ".4g", "mre": ".4g", "cube_root_rmse": ".4g",
           "held_out_rmse": ".4g", "held_out_cube_root_rmse": ".4g", "seconds": ".2f"}
"""What a row has beside its material, and how numbers are told."""

Row = dict[str, Any]


def ways(levels: Sequence[int] = ()) -> dict[str, Callable[[Samples], Fit]]:
    """The presets, and plain MBA of some levels: functions that fit samples, by name."""
    found: dict[str, Callable[[Samples], Fit]] = {name: partial(fit, **preset) for name, preset in PRESETS.items()}
    return found | {notation(level): partial(fit, diffuse_level=level, specular_level=None) for level in levels}


def rows(samples: Samples, fits: Mapping[str, Callable[[Samples], Fit]]) -> list[Row]:
    """A row of `COLUMNS` for each way of fitting.

    Errors are RMSE, MAE and MRE as of `error_metrics`, and root mean squares of differences of
    `cross_validation.cube_root`; held out are five folds, or of more than MANY samples one of them, as of
    `cross_validation.folds`. Of one sample none is held out. Seconds are of the processor, for the fit to all samples.
    """
    parts = cross_validation.folds(len(samples)) if len(samples) > 1 else []
    parts = parts[:1] if len(samples) > MANY else parts
    found = []
    for name, make in fits.items():
        start = time.process_time()
        model = make(samples)
        seconds = time.process_time() - start
        values = model.evaluate(*samples.directions)
        row: Row = {"material": samples.name, "source": strip_folders(samples.source), "fit": name,
                    "bytes": model.nbytes,
                    **error_metrics(samples.values, values)._asdict(),
                    "cube_root_rmse": cross_validation.errors(samples, values).cube_root_rmse,
                    "held_out_rmse": None, "held_out_cube_root_rmse": None, "seconds": seconds}
        if parts:
            predicted = samples.values.astype(float)
            for part in parts:
                predicted[part] = cross_validation.predict_part(samples, part, make)
            here = np.concatenate(parts)
            row["held_out_rmse"], row["held_out_cube_root_rmse"] = cross_validation.errors(
                subset(samples, here), predicted[here])
        found.append(row)
    return found


def materials(paths: Sequence[str | Path], **reading: Any) -> Iterator[Samples]:
    """All materials in files, read with the keyword arguments of `load`: every sample of a file that holds several."""
    for path in paths:
        numbers: list[int | None] = [number for number, _ in list_samples(path)]
        for number in numbers or [None]:
            yield load(path, number, **reading)


def markdown(found: Sequence[Row]) -> str:
    """Rows as a table of Markdown.

    Examples
    --------
    >>> print(markdown([{"material": "felt", **dict.fromkeys(COLUMNS), "fit": "Draft", "bytes": 5120}]).splitlines()[2])
    | felt | Draft | 5,120 |  |  |  |  |  |  |  |
    """
    lines = [f"| material | {' | '.join(name.replace('_', ' ') for name in COLUMNS)} |",
             "| --- | --- |" + " ---: |" * (len(COLUMNS) - 1)]
    for row in found:
        cells = ("" if row[name] is None else format(row[name], form) for name, form in COLUMNS.items())
        lines.append(f"| {printable(row['material']).replace('|', chr(92) + '|')} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def write(found: Sequence[Row], out: str | Path) -> None:
    """Write rows to a folder, which is made if necessary: `results.json` and `results.md`."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    with replace_file(folder / "results.json", "w") as stream:
        json.dump(list(found), stream, indent=1)
    with replace_file(folder / "results.md", "w") as stream:
        stream.write(markdown(found))
