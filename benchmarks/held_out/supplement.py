"""The held-out errors as a part of the report."""

import json
import os

from fitter.report import Supplement
from fitter.report.methods import METHODS
from support.checkout import ROOT

from . import pictures, run, sets, summary

FOLDER = ROOT / "build" / "held_out"


def judged_sets(_shown, out):
    """Errors over all sets at hand, from the last `make held-out` if there was one; else the judging half is judged."""
    found, left_out = sets.at_hand("judged")
    results = _earlier(FOLDER)
    if results is None:
        results = run.run(found, list(METHODS), FOLDER, os.cpu_count() or 1, True, left_out, lambda line: None)
    drawn = pictures.draw(results, FOLDER, out)
    text = (f"\n## Held-out errors over all sets at hand\n\n{origin(results, found)} Constants were chosen on one half "
            "of the materials, and are judged by the other.\n\n")
    return Supplement("judged_sets", text + summary.text(results, drawn), results)


def origin(results, found):
    """How the results were made, in words, and which of the sets `found` are not among them."""
    text = f"Made by `make held-out` at commit {results['commit']} in {results['seconds']:.0f} s ({results['machine']})"
    text += (", with the code of this report." if results["code"] == run.digest() else
             ". **They are older than the code of this report, which has changed since.**")
    missing = {each.name for each in found} - {record["name"] for record in results["sets"]}
    return text + (f" **{len(missing)} sets of the half that judges are not among them.**" if missing else "")


def _earlier(folder):
    path = folder / "results.json"
    return json.loads(path.read_text("utf-8")) if path.is_file() else None
