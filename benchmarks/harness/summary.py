"""The results in words: errors beside those of rivals, where they come from, and the page of a bench."""

import math
from pathlib import Path

from . import running


def ratio(rows, own, rivals, error):
    """The error of one model over the least of its rivals': at most 1 where it is best.

    Infinite where it failed, and not a number where the error of no rival is known.

    Examples
    --------
    >>> rows = {name: {"rmse": error} for name, error in (("Standard", 0.3), ("a", 0.2), ("b", 0.4))}
    >>> round(ratio(rows, "Standard", ("a", "b", "c"), "rmse"), 3)
    1.5
    """
    known = [rows[name][error] for name in rivals if name in rows and rows[name][error] is not None]
    if own not in rows or not known:
        return math.nan
    ours, least = rows[own][error], min(known)
    if ours is None:
        return math.inf
    return ours / least if least else (math.inf if ours else 1.0)


def page(results, pictures, *parts, tables=()):
    """Parts of a page, pictures, tables with their headings, and what was left out, as Markdown."""
    return "\n".join((*parts, *(f"![{Path(name).stem}]({name})\n" for name in pictures),
                      *(f"### {heading}\n\n{table}" for heading, table in tables),
                      *(f"Left out: {reason}.\n" for reason in results["left_out"])))


def origin(bench, results, found):
    """How the results were made, in words, and how many of the things `found` are not among them."""
    text = (f"Made by `make {bench.name.replace('_', '-')}` at commit {results['commit']} in {results['seconds']:.0f} "
            f"s of processors ({results['machine']})")
    text += (", with the code of this report." if results["code"] == running.digest(bench) else
             ". **They are older than the code of this report, which has changed since.**")
    missing = {each.name for each in found} - {record["name"] for record in results[bench.things]}
    return text + (f" **{len(missing)} {bench.things} are not among them.**" if missing else "")
