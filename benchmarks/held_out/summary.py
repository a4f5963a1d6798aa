"""The results in words and tables: how often Standard predicts best, and by how much it loses where it does not."""

import math

from ..harness import summary
from ..harness.judging import DIRECTIONS, STEEPEST
from ..report.markdown import table
from .judging import SMALL
from .sets import FAMILIES, HALVES

OWN = "Standard"
NEAR = 1.1                  # times the best of all methods
LIMIT = 16 << 10            # bytes a channel
WANTED = {"smallest_cube_root": 0.9, "near_cube_root": 1.0, "smallest_rmse": 0.75}
_PLACES = {"held_out": "at samples held out", "truth": f"at {DIRECTIONS:,} directions of the truth"}
_WORST = 5                  # ratios to tell
CAPTION = (f"Sets of up to {SMALL} samples are predicted in five folds, each from the other four; of larger ones a "
           f"fifth is predicted from the rest (one fold of the five, to be affordable), without samples beyond "
           f"{STEEPEST:.0f} degrees. Where the truth is known, the same fit, which has not seen the first fold, is "
           f"compared with it at {DIRECTIONS:,} directions too: a third of them near the mirror direction, a sixth "
           f"near the light's. Cube root: RMSE of the cube root of cosine-weighted values.\n")


def shares(records, place="held_out"):
    """Of how many of the sets Standard is best.

    Parameters
    ----------
    records : list of dict
        Of `judging.judge`.
    place : {"held_out", "truth"}

    Returns
    -------
    dict
        sets, and of them: smallest_cube_root, the share in which Standard has the smallest error by the cube root;
        near_cube_root, that in which it is at most NEAR times the best; smallest_rmse; worst_cube_root and worst_rmse,
        the sets in which Standard is behind and its ratio to the best, (name, ratio), the worst first; and
        largest_bytes, of Standard a channel. None where no set has a truth.
    """
    ratios = {error: {record["name"]: found for record in records if not math.isnan(found := summary.ratio(
        record["methods"], OWN, record["methods"].keys() - {OWN}, f"{place}_{error}"))}
              for error in ("rmse", "cube_root_rmse")}
    count = len(ratios["rmse"])
    if not count:
        return None

    def share(error, limit):
        return sum(found <= limit for found in ratios[error].values()) / count

    def worst(error):
        behind = [(name, found) for name, found in ratios[error].items() if found > 1]
        return sorted(behind, key=lambda each: -each[1])

    return {"sets": count, "smallest_cube_root": share("cube_root_rmse", 1), "near_cube_root": share(
        "cube_root_rmse", NEAR), "smallest_rmse": share("rmse", 1), "worst_cube_root": worst("cube_root_rmse"),
        "worst_rmse": worst("rmse"),
        "largest_bytes": max(bytes_per_channel(record) or 0 for record in records if record["name"] in ratios["rmse"])}


def bytes_per_channel(record):
    """Bytes of Standard for each channel that it stores; None where it failed."""
    total = record["methods"][OWN]["bytes"]
    return None if total is None else total / record["channels"]


def text(results, pictures=()):
    """All of it as Markdown, without a heading of its own: the shares, the pictures and the table of all sets."""
    return summary.page(results, pictures, shares_text(results),
                        tables=[("All sets", f"{CAPTION}\n{all_sets(results)}")])


def shares_text(results):
    """The shares, for each half and family, and the worst ratios."""
    parts = []
    for place, where in _PLACES.items():
        rows, worst = [], []
        for half, family, records in _groups(results["sets"]):
            found = shares(records, place)
            if found is None:
                continue
            rows.append((half, family, found["sets"], *(_percent(found[key]) for key in WANTED),
                         f"{found['largest_bytes']:,.0f}"))
            if family == "all":
                worst += [f"- {half}, {label}: {_worst(found[key])}" for key, label in (
                    ("worst_cube_root", "cube root"), ("worst_rmse", "RMSE"))]
        if rows:
            rows.append(("wanted", "", "", *(_percent(share) for share in WANTED.values()), f"at most {LIMIT:,}"))
            parts += [f"{OWN} {where}: the share of the sets in which it has the smallest error of all methods.\n",
                      table(("half", "family", "sets", "smallest, cube root", f"within {NEAR} of the best, cube root",
                             "smallest, RMSE", "most bytes a channel"), rows),
                      f"Where {OWN} is behind, times the best of the others:\n", *worst, ""]
    return "\n".join(parts)


def all_sets(results):
    """The errors of each method in every set, the best in bold."""
    methods = results["methods"]
    rows = []
    for half in HALVES:
        for record in results["sets"]:
            if record["half"] == half:
                rows += _rows(record, methods)
    return "RMSE / cube root.\n\n" + table(("half", "set", "judged at", f"{OWN}, bytes a channel", *methods), rows)


def _rows(record, methods):
    for place in _PLACES:
        found = {name: [record["methods"][name][f"{place}_{error}"] for error in ("rmse", "cube_root_rmse")]
                 for name in methods}
        known = [pair for pair in found.values() if pair[0] is not None]
        if not known and place == "truth":
            continue
        best = [min((pair[kind] for pair in known), default=None) for kind in (0, 1)]
        size = bytes_per_channel(record)
        yield (record["half"], record["name"], f"{record['judged']:,} of {record['samples']:,} samples"
               if place == "held_out" else "the truth", "" if size is None or place == "truth" else f"{size:,.0f}",
               *(" / ".join(_marked(value, least) for value, least in zip(found[name], best, strict=True))
                 if found[name][0] is not None else "failed" for name in methods))


def _groups(records):
    """(half, family, records) for each of both, and for the families of a half together, "all"."""
    for half in HALVES:
        of_half = [record for record in records if record["half"] == half]
        for family in (*FAMILIES, "all"):
            found = [record for record in of_half if family in ("all", record["family"])]
            if found:
                yield half, family, found


def _worst(behind):
    told = ", ".join(f"{name} {'failed' if math.isinf(found) else f'{found:#.3g}'}" for name, found in behind[:_WORST])
    rest = len(behind) - _WORST
    return (told or "nowhere") + (f", and {rest} more" if rest > 0 else "")


def _percent(share):
    return f"{100 * share:.0f} %"


def _marked(value, best):
    return f"**{value:.3g}**" if value == best else f"{value:.3g}"
