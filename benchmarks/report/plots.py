"""The plots that compare materials or methods."""

import math
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .methods import BASELINES
from .tables import Results, Row

mpl.use("Agg")
METRICS = ("rmse", "mae", "mre")


def draw(results: Results, out: Path) -> None:
    """Write the plots to a folder."""
    drawn = {"figure_1_errors.png": _errors, "figure_2_times.png": _times, "figure_5_storage.png": _storage}
    for name, function in drawn.items():
        save(function(results), out / name)


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a PNG file and free its memory."""
    figure.savefig(path, dpi=75)
    pyplot.close(figure)


def rows_of(results: Results, material: str, source: str) -> dict[str, Row]:
    """The errors of one material, by method."""
    return {row["method"]: row for row in results["errors"] if (row["material"], row["source"]) == (material, source)}


def _errors(results: Results) -> Figure:
    """Errors against level, and those of the baselines as horizontal lines: the paper's Figure 1."""
    figure, axes = pyplot.subplots(len(results["featured"]), len(METRICS), squeeze=False, constrained_layout=True,
                                   figsize=(4 * len(METRICS), 2.5 * len(results["featured"])))
    levels = results["levels"]
    for line, (name, source) in zip(axes, results["featured"], strict=True):
        methods = rows_of(results, name, source)
        for metric, axis in zip(METRICS, line, strict=True):
            axis.semilogy(levels, [methods[f"level {level}"][metric] for level in levels], "o-", label="MBA")
            for baseline, style in zip(BASELINES, cycle(("--", ":", "-.")), strict=False):
                axis.axhline(methods[baseline][metric], color="black", linestyle=style, label=baseline)
            axis.set_title(f"{name}: {metric.upper()}", fontsize=9)
            axis.set_xticks(levels, [f"{level}\n{methods[f'level {level}']['coefficients']:,}" for level in levels],
                            fontsize=6)
    axes[0, 0].legend(fontsize=7)
    figure.supxlabel("level, and coefficients stored", fontsize=8)
    return figure


def _bars(axis: Axes, names: Sequence[str], values: Sequence[float]) -> None:
    axis.barh(range(len(names)), values)
    axis.set_yticks(range(len(names)), names, fontsize=7)
    axis.set_ylim(len(names) - 0.4, -0.6)       # downward


def _times(results: Results) -> Figure:
    """Time of one evaluation by each method: the paper's Figure 2."""
    figure, axis = pyplot.subplots(figsize=(7, 3), constrained_layout=True)
    rows = results["times"]["rows"]
    _bars(axis, [row["method"] for row in rows], [row["nanoseconds"] for row in rows])
    axis.set_xlabel(f"nanoseconds a call in NumPy, {results['times']['material']}")
    return figure


def _storage(results: Results) -> Figure:
    """Parameters and bytes of one channel, ours and those of the paper's Figure 5 and Table 1."""
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4), constrained_layout=True, sharey=True)
    name, source = results["featured"][0]
    errors = rows_of(results, name, source)
    plain = [f"level {level}" for level in results["levels"]]
    ours = {method: (errors[method]["coefficients"], 4 * errors[method]["coefficients"])
            for method in (*plain, *BASELINES)} | {
        row["fit"]: (row["coefficients"], row["bytes"]) for row in results["storage"]}
    papers = {method: ((2 ** level + 3) ** 3, 4 * (2 ** level + 3) ** 3)
              for level, method in zip(results["levels"], plain, strict=True)} | {
        row["fit"]: (row["paper_coefficients"], row["paper_bytes"]) for row in results["storage"]} | {
        "Koenderink 8": (55, 220), "Lafortune 3": (10, 40)}
    for axis, index, title in zip(axes, (0, 1), ("parameters", "bytes, single precision"), strict=True):
        _bars(axis, list(ours), [size[index] for size in ours.values()])
        marks = [papers[method][index] if method in papers else math.nan for method in ours]
        axis.plot(marks, range(len(ours)), "k|", markersize=9, label="the paper's")
        axis.set_xscale("log")
        axis.set_title(f"{title}, one channel", fontsize=9)
    axes[0].legend(fontsize=7)
    return figure
