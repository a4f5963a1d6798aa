"""A plugin of pytest, ``-p tools.reached``, that writes which lines of the addon each quick test reaches.

The file of `path` gets a line of JSON for each that passed: its name, its seconds, and the lines, by file. What other
processes run is not seen.
"""

import json
import sys
import threading
import time
from functools import cache

import pytest

from support.checkout import ROOT
from support.evidence import digest

_reached = set()


def path():
    """Where it is written, once the tests have ended, for the code as it is."""
    return ROOT / "build" / "mutants" / f"reached_{digest(('addon', 'fitter', 'tests'))}.jsonl"


def pytest_configure(config):
    """Begin the file."""
    config.reached_part = path().with_suffix(".part")
    if not hasattr(config, "workerinput"):
        config.reached_part.parent.mkdir(parents=True, exist_ok=True)
        config.reached_part.write_text("")


def pytest_sessionfinish(session, exitstatus):
    """Give the file its name, unless the tests were interrupted."""
    if not hasattr(session.config, "workerinput") and exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        session.config.reached_part.rename(path())


@cache
def _is_traced(file):
    return file.startswith(str(ROOT / "addon")) and file.endswith(".py")


def _on_call(frame, event, _argument):
    return _on_line if _is_traced(frame.f_code.co_filename) else None


def _on_line(frame, event, _argument):
    if event == "line":
        _reached.add((frame.f_code.co_filename, frame.f_lineno))
    return _on_line


def pytest_runtest_protocol(item):
    """Trace a quick test with its fixtures."""
    if item.get_closest_marker("release") is not None:
        return
    _reached.clear()
    item.reached_from = time.perf_counter()
    sys.settrace(_on_call)
    threading.settrace(_on_call)


def pytest_runtest_teardown(item):
    """Trace no more."""
    sys.settrace(None)
    threading.settrace(None)


def pytest_runtest_makereport(item, call):
    """Write what a test has reached."""
    if call.when == "call" and call.excinfo is None and hasattr(item, "reached_from"):
        lines = {}
        for file, line in _reached:
            lines.setdefault(file.removeprefix(f"{ROOT}/"), []).append(line)
        with item.config.reached_part.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps({"test": item.nodeid, "seconds": time.perf_counter() - item.reached_from,
                                     "lines": lines}) + "\n")
