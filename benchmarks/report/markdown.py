"""The report as Markdown: tables, and the sentences that count them."""

from collections import Counter
from pathlib import Path
from statistics import median

from support.evidence import show as show_text
from support.evidence import show_table

from .methods import BASELINES, RIVALS

_COMPARED = {"bytes": "bytes", "RMSE": "rmse", "held-out RMSE": "held_out_rmse", "RMSE of cube root": "cube_root_rmse",
             "held-out, cube root": "held_out_cube_root_rmse", "reciprocity error": "reciprocity_error",
             "negative": "negative_fraction", "fit [s]": "fit_seconds", "evaluate [µs]": "evaluate_microseconds"}


def show(results):
    """Print all tables of `results.json`, each under its name."""
    _claim(results)
    by_method = {}
    for material in results["featured"]:
        for row in results["errors"]:
            if [row["material"], row["source"]] == material:
                by_method.setdefault(row["method"], []).append(row)
    show_table("report-errors", ("method", "coefficients", *(name for name, _ in results["featured"])),
               [(method, max(row["coefficients"] for row in found),
                 *(" / ".join(f"{row[key]:.3g}" for key in ("rmse", "mae", "mre")) for row in found))
                for method, found in by_method.items()])
    show_table("report-times", ("method", "ns a call in NumPy"),
               [(row["method"], row["nanoseconds"]) for row in results["times"]["rows"]])
    show_table("report-storage", ("fit", "control points", "the paper's", "bytes", "the paper's"),
               [(row["fit"], row["coefficients"], row["paper_coefficients"], row["bytes"], row["paper_bytes"])
                for row in results["storage"]])
    show_table("report-methods", ("material", "method", *_COMPARED),
               [(name, method, *(median(row[key] for row in rows) for key in _COMPARED.values()))
                for name, rows_by_method in _groups(results["comparison"]) for method, rows in rows_by_method.items()])
    show_table("report-pictures", ("fit", "relative RMSE", "mean FLIP"),
               [(row["fit"], row["relative_rmse"], row["flip"]) for row in results["renders"]])
    _wins(results)


def _claim(results):
    """Section 3.4: level 6 is at least 4 times better than the baselines, level 4 is comparable."""
    rows = results["claims"]
    several = {source for source, count in Counter(row["source"] for row in rows).items() if count > 1}
    lines = []
    for name, group in (("files of many materials (CURET)", [row for row in rows if row["source"] in several]),
                        ("single files (Cornell)", [row for row in rows if row["source"] not in several])):
        if group:
            fine, coarse = (sum(row[key] for row in group) for key in ("level_6_holds", "level_4_holds"))
            lines.append((name, len(group), fine, median(row["level_6_factor"] for row in group), coarse))
    show_table("report-claim", ("", "materials", "level 6 four times better", "in the median, times",
                                "level 4 within a factor of 2"), lines)


def _wins(results):
    """For how many materials Standard has smaller errors than the paper's baselines, and than all others."""
    rows = {}
    for row in results["comparison"]:
        rows.setdefault((row["material"], row["source"]), {})[row["method"]] = row
    for name, others in (("baselines", BASELINES), ("all", ("level 6", *BASELINES, *RIVALS))):
        seen, unseen, cube = (
            sum(all(found["Standard"][key] < found[other][key] for other in others) for found in rows.values())
            for key in ("rmse", "held_out_rmse", "held_out_cube_root_rmse"))
        show_text(f"report-beats-{name}", f"{seen} of {len(rows)} materials at the samples, {unseen} at samples not "
                                          f"seen (by the cube root {cube})")
    krylon = next((found for (name, _), found in rows.items() if name == "Krylon Blue"), None)
    if krylon:
        show_text("report-krylon", "Paper {Paper:,} bytes, Standard {Standard:,}, uncompressed (level 6) {level 6:,}"
                  .format(**{name: row["bytes"] for name, row in krylon.items()}))
    show_text("report-bytes", "{:,} bytes".format(next(row["bytes"] for row in results["storage"]
                                                       if row["fit"] == "(4,6,95)")))


def _groups(rows):
    """(name, rows by method) for each file."""
    count = Counter(row["source"] for row in rows if row["method"] == rows[0]["method"])
    groups = {}
    for row in rows:
        several = count[row["source"]] > 1
        file = Path(row["source"]).name
        name = f"{file}, {count[row['source']]} materials" if several else f"{row['material']} ({file})"
        groups.setdefault(name, {}).setdefault(row["method"], []).append(row)
    return groups.items()
