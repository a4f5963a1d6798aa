"""``python -m fitter report``: the paper's claims as tables and plots, on real data.

`tables` computes, `markdown` writes the tables, `plots` draws them (matplotlib, an optional extra). Plots are left out
where matplotlib is not installed, and the report says so.
"""

import json
from pathlib import Path

from ..datasets import list_samples, load
from ..files import replacing
from . import markdown, plots, tables

LEVELS = range(8)
BILEVEL = ((1, 6, 90), (3, 6, 90), (4, 6, 95), (4, 6, 99))


def measurements(paths):
    """All measurements in some files: every sample of a CURET file, and each other file's one."""
    for path in paths:
        numbers = [number for number, _ in list_samples(path)] or [None]
        for number in numbers:
            yield load(path, number)


def write(paths, out, levels=LEVELS, progress=lambda done, total, name: None):
    """Write `results.json`, `results.md` and, with matplotlib, PNG plots to a folder.

    Parameters
    ----------
    paths : list of path-like
        Files of measurements.
    out : path-like
        The folder, made where it is not there.
    levels : sequence of int
        Levels of plain MBA to report.
    progress : callable
        Told (done, total, name) before each measurement.

    Returns
    -------
    dict
        What results.json holds.
    """
    out = Path(out)
    samples = list(measurements(paths))
    rows = []
    for done, measured in enumerate(samples):
        progress(done, len(samples), measured.name)
        rows += tables.errors(measured, levels, BILEVEL)
    progress(len(samples), len(samples), "")
    results = {"levels": list(levels), "errors": rows, "storage": tables.storage(samples[0]),
               "claims": tables.claims(rows)}
    out.mkdir(parents=True, exist_ok=True)
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    pictures = plots.draw(results, out)
    with replacing(out / "results.md", "w") as stream:
        stream.write(markdown.report(results, pictures))
    return results
