"""A bench as a command, and as a part of the report."""

import argparse
import json
import os
import sys
from pathlib import Path

from fitter.files import replacing

from ..report import Supplement
from . import running, summary


def parser(bench, description):
    """The options of the command."""
    found = argparse.ArgumentParser(prog=f"python -m benchmarks.{bench.name}", description=description.splitlines()[0])
    found.add_argument(f"--{bench.things}", nargs="+", default=(), metavar="NAME", dest="names",
                       help="only those whose names contain one of these; all by default")
    found.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes, default: %(default)s")
    found.add_argument("--resume", action="store_true", help="go on with an interrupted run of the same code")
    found.add_argument("--out", type=Path, default=bench.folder, help="folder to write, default: %(default)s")
    return found


def judge(bench, found, left_out, options):
    """Judge what was found, write the page, the results and the pictures, and print what matters most."""
    for reason in left_out:
        print(f"left out: {reason}")
    if not found:
        sys.exit(f"no {bench.things} of these names are at hand")
    results = running.run(bench, found, options.out, options.jobs, options.resume, left_out,
                          lambda line: print(line, flush=True))
    page = options.out / f"{bench.name}.md"
    with replacing(page, "w") as stream:
        stream.write(f"# {bench.title}\n\nCommit {results['commit']}.\n\n"
                     + bench.text(results, bench.draw(results, options.out)))
    print(f"\n{bench.outcome(results)}\n{page}, in {results['seconds']:.0f} s of processors")


def supplement(bench, key, found, left_out, out):
    """The part of the report, of the last results of the command; where there are none, they are made."""
    path = bench.folder / "results.json"
    results = json.loads(path.read_text("utf-8")) if path.is_file() else running.run(
        bench, found, bench.folder, os.cpu_count() or 1, True, left_out, lambda line: None)
    text = f"\n## {bench.title}\n\n{summary.origin(bench, results, found)}{bench.about}\n\n"
    return Supplement(key, text + bench.text(results, bench.draw(results, bench.folder, out)), results)
