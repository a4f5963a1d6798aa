"""The tables of the report as Markdown."""

from pathlib import Path

_HEADING = """# Results

Errors at the samples (Kameya and Lewis 2002, equations 8 to 10; MAE is the *maximum* absolute deviation), 1/sr, over
all channels. Coefficients are counted for one channel. Written by `python -m fitter report`.
"""


def table(header, rows):
    """A Markdown table: numbers to the right."""
    text = [[_cell(value) for value in row] for row in rows]
    rule = ["---:" if rows and isinstance(value, int | float) and not isinstance(value, bool) else "---"
            for value in (rows[0] if rows else header)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [list(header), rule, *text]) + "\n"


def report(results, pictures):
    """The whole report; `pictures` are file names beside it."""
    parts = [_HEADING, "## Does the paper's claim hold?\n", _claims(results["claims"]),
             "## Storage, one channel (the paper's Table 1)\n", _storage(results["storage"]),
             "## Errors, by level and compressed (the paper's Figures 1 and 6)\n", _errors(results["errors"])]
    parts += [f"![{Path(name).stem}]({name})\n" for name in pictures]
    if not pictures:
        parts.append("No plots: matplotlib is not installed.\n")
    return "\n".join(parts)


def _claims(rows):
    if not rows:
        return "Levels 4 and 6 were not both asked for.\n"
    fine, coarse = (sum(row[key] for row in rows) for key in ("level_6_holds", "level_4_holds"))
    return (f"Level 6 is at least 4 times better in RMSE than the better baseline for {fine} of {len(rows)} materials; "
            f"level 4 is comparable (within a factor of 2) for {coarse}.\n\n"
            + table(("material", "file", "baseline / level 6", "baseline / level 4", "4 times better", "comparable"),
                    [(row["material"], Path(row["source"]).name, row["level_6_factor"], row["level_4_factor"],
                      row["level_6_holds"], row["level_4_holds"]) for row in rows]))


def _storage(rows):
    return table(("fit", "control points", "the paper's", "bytes", "the paper's"),
                 [(row["fit"], row["coefficients"], row["paper_coefficients"], row["bytes"], row["paper_bytes"])
                  for row in rows])


def _errors(rows):
    return table(("material", "file", "method", "coefficients", "bytes", "RMSE", "MAE", "MRE"),
                 [(row["material"], Path(row["source"]).name, row["method"], row["coefficients"], row["bytes"],
                   row["rmse"], row["mae"], row["mre"]) for row in rows])


def _cell(value):
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else str(value).replace("|", "\\|")
