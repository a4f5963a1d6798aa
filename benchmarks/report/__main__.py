"""``make report``: `python -m fitter report`, with errors over all sets at hand, times inside OSL, and renders.

The latter two need Blender.

python -m benchmarks.report FILE... --out build/report
"""

import argparse
import contextlib
import os
import sys
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

from support.checkout import extension

from ..dense.bench import dense_sets
from ..held_out.bench import judged_sets
from . import Supplement, findings, markdown, plots, run


def times_in_cycles(shown, out):
    """Figure 2, inside Cycles."""
    from .. import osl_times

    with _quiet():
        rows = osl_times.table(shown[0])
    calls = osl_times.PIXELS * (osl_times.MANY - osl_times.FEW)
    text = (f"\n## Evaluation times inside Cycles OSL (Figure 2)\n\n{calls:,} calls on one core, {shown[0].name}, one "
            f"channel; the least of {osl_times.REPEATS}. {findings.flatness(rows)}\n\n")
    plots.save(plots.times(rows, f"nanoseconds a call in OSL, {shown[0].name}"), out / "figure_2_osl.png")
    text += "![figure_2_osl](figure_2_osl.png)\n\n"
    return Supplement("osl_times", text + markdown.table(("method", "ns a call in OSL"), [
        (row["method"], row["nanoseconds"]) for row in rows]), rows)


def rendered_by_cycles(shown, out):
    """Figures 3, 4, 7 and 8."""
    from .. import figures

    by_name = {samples.name: samples for samples in shown}
    leading = [by_name[name] for name in ("aluminum foil", "felt", "leather") if name in by_name] or shown[:3]
    glossy = by_name.get("Krylon Blue", shown[-1])
    with _quiet():
        names = [figures.levels(leading[0], out), figures.materials(leading, out),
                 figures.compressed([*leading, glossy], out)]
        name, rows = figures.undetectable(glossy, out)
    text = "\n## Rendered by Cycles (Figures 3, 4, 7 and 8)\n\n" + "".join(
        f"![{Path(picture).stem}]({picture})\n\n" for picture in (*names, name))
    text += (f"Figure 8, where the paper calls the differences undetectable: pictures of {glossy.name} against level "
             "6 (RMSE of scene-linear pixels over the picture's mean; FLIP, 0 to 1, of the pictures as shown). The "
             "first row is what noise alone makes.\n\n")
    text += markdown.table(("fit", "relative RMSE", "mean FLIP"), [
        (row["fit"], row["relative_rmse"], "flip-evaluator is not installed" if row["flip"] is None else row["flip"])
        for row in rows])
    return Supplement("renders", text + _against_noise(rows), rows)


def _against_noise(rows):
    """Figure 8 in words: the difference of each fit over that of noise."""
    noise, *others = rows
    told = "; ".join(f"{row['fit']} {row['relative_rmse'] / noise['relative_rmse']:.2g}"
                     + (f" and {row['flip'] / noise['flip']:.2g}" if noise["flip"] else "") for row in others)
    return f"\nTimes the difference that noise makes, RMSE and FLIP: {told}.\n"


@contextlib.contextmanager
def _quiet():
    """Blender reports every picture on the process's standard output, below Python's."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def main():
    """Write the report."""
    from measured_brdf.addon.core import osl_support

    parser = argparse.ArgumentParser(prog="python -m benchmarks.report", description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help="measurements; all samples of a CURET file")
    parser.add_argument("--out", default="build/report", help="folder to write, default: %(default)s")
    options = parser.parse_args()
    if osl_support.missing():
        sys.exit(osl_support.missing())
    run(options.files, options.out, supplements=(judged_sets, dense_sets, times_in_cycles, rendered_by_cycles))


if __name__ == "__main__":
    extension().register()
    main()
