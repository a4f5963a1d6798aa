"""A plugin of pytest, ``-p tools.durations``, that says where the time of the tests goes, and a check of what grew.

It prints the slowest tests and the seconds of each folder, and writes those of each test into build/durations.csv.
Seconds are of a processor, of child processes that ended too: other work on the machine changes them little. What a
file may take stands in tests/durations.csv. ``python -m tools.durations --check`` compares the last run with it, and
``--accept`` writes it.
"""

import argparse
import csv
import os
import statistics
import sys
from collections import Counter

import pytest

from support.checkout import ROOT

LAST, ALLOWED = ROOT / "build" / "durations.csv", ROOT / "tests" / "durations.csv"
GROWN = 1.5                 # times what a file may take
LEAST = 4.0                 # s: what takes less by then may grow by more
_SLOWEST = 25
_LONGEST = 200              # characters of a name: some have a whole file among their parameters
_KEY = "processor seconds"
_tests = Counter()


def _spent():
    """Seconds of a processor that this process and those that it has waited for have taken."""
    return sum(os.times()[:4])


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item):
    """A test begins with its fixtures."""
    item.spent_before = _spent()
    return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item):
    """A test ends with its fixtures; the report of that carries the seconds to the process that prints them."""
    try:
        return (yield)
    finally:
        item.user_properties.append((_KEY, _spent() - item.spent_before))


def pytest_runtest_logreport(report):
    """Take the seconds of a test."""
    if report.when == "teardown":
        _tests[report.nodeid] += dict(report.user_properties).get(_KEY, 0.0)


def pytest_terminal_summary(terminalreporter):
    """Print the slowest tests and the folders, and write the seconds of all tests."""
    folders = Counter()
    for name, seconds in _tests.items():
        file = name.partition("::")[0]
        folders["/".join(file.split("/")[:2 + (file.count("/") > 2)][:file.count("/")])] += seconds
    terminalreporter.section("seconds of a processor")
    for name, seconds in _tests.most_common(_SLOWEST):
        terminalreporter.write_line(f"{seconds:8.2f}  {name}")
    for name, seconds in (*folders.most_common(), ("all tests", sum(folders.values()))):
        terminalreporter.write_line(f"{seconds:8.1f}  {name}")
    LAST.parent.mkdir(exist_ok=True)
    _write(LAST, _tests)


def _write(path, found):
    with path.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream, lineterminator="\n")
        rows.writerow(("name", "seconds"))
        rows.writerows((name[:_LONGEST], f"{seconds:.2f}") for name, seconds in sorted(found.items()))


def read(path):
    """The seconds of each file, of a list of files or of tests."""
    files = Counter()
    with path.open(newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            files[row["name"].partition("::")[0]] += float(row["seconds"])
    return files


def grown(now, allowed):
    """Lines about the files that take more than they may, as far as the speed of this machine is known from all."""
    slower = statistics.median(now[name] / allowed[name] for name in now.keys() & allowed.keys()
                               if allowed[name] >= LEAST)
    return [f"{name}: {seconds / slower:.1f} s, {allowed.get(name, 0.0):.1f} s allowed" for name, seconds in now.items()
            if seconds / slower > max(GROWN * allowed.get(name, 0.0), LEAST)]


def main(arguments=None):
    """Compare the last run with what is allowed, or allow what it took."""
    parser = argparse.ArgumentParser(prog="python -m tools.durations", description=__doc__)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--check", action="store_true", help="fail where a file takes half as much again as it may")
    action.add_argument("--accept", action="store_true", help="allow each file what it took in the last run")
    options = parser.parse_args(arguments)
    now = read(LAST)
    if options.accept:
        _write(ALLOWED, now)
        return 0
    lines = grown(now, read(ALLOWED))
    print(*lines, f"{len(lines)} of {len(now)} files of tests have grown", sep="\n")
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
