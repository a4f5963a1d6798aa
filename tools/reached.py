"""A plugin of pytest that writes which lines of the addon each test reaches: ``-p tools.reached --reached FILE``.

FILE gets a line of JSON for each test that passed: its name, its seconds, and the lines, by file. What other processes
run is not seen.
"""

import json
import sys
import threading
import time

from support.checkout import ROOT

_reached = set()
_traced = {}


def pytest_addoption(parser):
    """Add the option."""
    parser.addoption("--reached", default=None)


def _is_traced(file):
    if file not in _traced:
        _traced[file] = file.startswith(str(ROOT / "addon")) and file.endswith(".py")
    return _traced[file]


def _on_call(frame, event, _argument):
    return _on_line if _is_traced(frame.f_code.co_filename) else None


def _on_line(frame, event, _argument):
    if event == "line":
        _reached.add((frame.f_code.co_filename, frame.f_lineno))
    return _on_line


def pytest_runtest_protocol(item):
    """Trace a test with its fixtures."""
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
    out = item.config.getoption("--reached")
    if out and call.when == "call" and call.excinfo is None:
        lines = {}
        for file, line in _reached:
            lines.setdefault(file.removeprefix(f"{ROOT}/"), []).append(line)
        with open(out, "a", encoding="utf-8") as stream:
            stream.write(json.dumps({"test": item.nodeid, "seconds": time.perf_counter() - item.reached_from,
                                     "lines": lines}) + "\n")
