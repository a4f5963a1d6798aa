"""The report as Markdown."""

from collections import Counter
from collections.abc import ItemsView, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from . import findings
from .methods import METHODS
from .rows import Results, Row

_HEADING = """# Results

Made by `make report` in {seconds:.0f} s, {processor_seconds:.0f} s of processors ({machine}), which also writes all
numbers into `results.json`. RMSE, MAE and MRE are equations 8 to 10 of Kameya and
Lewis (2002), at the samples and over all channels, in 1/sr; MAE is the *maximum* absolute deviation. Coefficients are
counted for one channel.
"""
_COMPARED = {"bytes": "bytes", "RMSE": "rmse", "held-out RMSE": "held_out_rmse", "RMSE of cube root": "cube_root_rmse",
             "held-out, cube root": "held_out_cube_root_rmse", "ringing": "ringing",
             "reciprocity error": "reciprocity_error", "negative": "negative_fraction", "fit [s]": "fit_seconds",
             "evaluate [µs]": "evaluate_microseconds"}
NO_RENDERER = ("\n## In Cycles\n\nTimes inside Cycles OSL and rendered pictures are made by `make report`, which has "
               "Blender; this report was made without it.\n")


def table(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A Markdown table; numbers are aligned to the right.

    Examples
    --------
    >>> print(table(("material", "bytes"), [("felt", 16384)]), end="")
    | material | bytes |
    | --- | ---: |
    | felt | 16,384 |
    """
    text = [[_cell(value) for value in row] for row in rows]
    rule = ["---:" if rows and isinstance(value, int | float) and not isinstance(value, bool) else "---"
            for value in (rows[0] if rows else header)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [list(header), rule, *text]) + "\n"


def main(results: Results, pictures: Sequence[str], supplements: Sequence[str] = ()) -> str:
    """The summary.

    Parameters
    ----------
    results : dict
        What results.json holds.
    pictures : sequence of str
        File names of two polar plots, in the same folder.
    supplements : sequence of str
        Markdown to append.
    """
    def shown(*names: str) -> str:
        return "".join(f"![{Path(name).stem}]({name})\n\n" for name in names)

    parts = [
        _HEADING.format(**results), findings.differences(results),
        "\n## Errors by level (Figure 1)\n\n", findings.claims(results), shown("figure_1_errors.png"),
        shown("figure_1_claim.png"), featured_errors(results),
        "\n## Evaluation times (Figure 2)\n\n", findings.times(results),
        table(("method", "ns a call in NumPy"), [(row["method"], row["nanoseconds"])
                                                 for row in results["times"]["rows"]]), "\n",
        shown("figure_2_times.png"),
        "\n## Storage of one channel (Figure 5, Table 1)\n\n", _storage(results), "\n", shown("figure_5_storage.png"),
        "\n## Compressed (Figure 6)\n\n", findings.compressed(results), shown("figure_6_compressed.png"),
        "\n## Ringing\n\n", findings.ringing(results), _ringing(results), "\n", shown("ringing.png", *pictures[:1]),
        "\n## Methods side by side\n\n", _side_by_side(results),
        "\n## Held-out errors\n\n", _held_out(results),
        "\n## Physics\n\n", findings.physics(results), shown("albedo.png"),
        "\n## A slice\n\n", shown(*pictures[1:]), *(supplements or [NO_RENDERER])]
    return "".join(parts).replace("\n\n\n", "\n\n")


def featured_errors(results: Results) -> str:
    """Errors by method; one column for each featured material."""
    by_method: dict[str, list[Row]] = {}
    for material in results["featured"]:
        for row in results["errors"]:
            if [row["material"], row["source"]] == material:
                by_method.setdefault(row["method"], []).append(row)
    return ("RMSE / MAE / MRE:\n\n" + table(
        ("method", "coefficients", *(name for name, _ in results["featured"])),
        [(method, max(row["coefficients"] for row in found),
          *(" / ".join(f"{row[key]:.3g}" for key in ("rmse", "mae", "mre")) for row in found))
         for method, found in by_method.items()]))


def _storage(results: Results) -> str:
    return table(("fit", "control points", "the paper's", "bytes", "the paper's"),
                 [(row["fit"], row["coefficients"], row["paper_coefficients"], row["bytes"], row["paper_bytes"])
                  for row in results["storage"]])


def _ringing(results: Results) -> str:
    methods = list(dict.fromkeys(row["method"] for row in results["ringing"]))
    return table(("material", *methods),
                 [(name, *(row["ringing"] for row in results["ringing"] if (row["material"], row["source"]) ==
                           (name, source))) for name, source in results["featured"]])


def _side_by_side(results: Results) -> str:
    """Medians over the materials of files with several, and the values of each other material."""
    return ("Paper is the paper's method at the levels it recommends, Standard what this project renders with (both "
            "in `fitter.PRESETS`), level 6 the paper's plain MBA. Where a file holds several materials, medians over "
            "them. Times are those of the processor.\n\n" + table(
        ("material", "method", *_COMPARED),
        [(name, method, *(median(row[key] for row in rows) for key in _COMPARED.values()))
         for name, rows_by_method in _groups(results["comparison"]) for method, rows in rows_by_method.items()]))


def _groups(rows: list[Row]) -> ItemsView[str, dict[str, list[Row]]]:
    """(name, rows by method) for each file."""
    count = Counter(row["source"] for row in rows if row["method"] == rows[0]["method"])
    groups: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        several = count[row["source"]] > 1
        file = Path(row["source"]).name
        name = f"{file}, {count[row['source']]} materials" if several else f"{row['material']} ({file})"
        groups.setdefault(name, {}).setdefault(row["method"], []).append(row)
    return groups.items()


def _held_out(results: Results) -> str:
    rows: dict[tuple[str, str], dict[str, Row]] = {}
    for row in results["comparison"]:
        rows.setdefault((row["material"], row["source"]), {})[row["method"]] = row
    return ("Five folds, each predicted from the other four; RMSE / RMSE of the cube root of cosine-weighted values. "
            + findings.held_out(results) + table(
                ("material", *METHODS),
                [(name, *(f"{row['held_out_rmse']:.3g} / {row['held_out_cube_root_rmse']:.3g}"
                          for row in rows[name, source].values())) for name, source in results["featured"]]))


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else str(value).replace("|", "\\|")
