"""The dense measurements as a part of the report."""

import json
import os

from fitter.report import Supplement
from support.checkout import ROOT

from . import materials, run, sheet, summary

FOLDER = ROOT / "build" / "dense"


def dense_sets(_shown, out):
    """Errors on dense measurements, from the last `make dense` if there was one; else they are made."""
    found, left_out = materials.at_hand()
    path = FOLDER / "results.json"
    if path.is_file():
        results = json.loads(path.read_text("utf-8"))
    else:
        results = run.run(found, FOLDER, os.cpu_count() or 1, True, left_out, lambda line: None)
    text = f"\n## Dense measurements\n\n{origin(results, found)}\n\n"
    return Supplement("dense_sets", text + summary.text(results, sheet.draw(results, FOLDER, out)), results)


def origin(results, found):
    """How the results were made, in words, and how many of the materials `found` are not among them."""
    text = (f"Made by `make dense` at commit {results['commit']} in {results['seconds']:.0f} s of processors "
            f"({results['machine']})")
    text += (", with the code of this report." if results["code"] == run.digest() else
             ". **They are older than the code of this report, which has changed since.**")
    missing = {each.name for each in found} - {record["name"] for record in results["materials"]}
    return text + (f" **{len(missing)} materials are not among them.**" if missing else "")
