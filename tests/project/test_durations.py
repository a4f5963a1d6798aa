"""Which files of tests are said to have grown, and what a run prints and writes."""

import subprocess
import sys

import pytest

from support.checkout import ROOT
from tools import durations


def test_what_grew_by_half_is_named_however_slow_the_machine_is():
    allowed = {"a.py": 10.0, "b.py": 20.0, "c.py": 30.0, "d.py": 5.0, "e.py": 6.0, "f.py": 7.0, "quick.py": 0.1}
    for slower in (1, 3):
        now = {name: slower * seconds for name, seconds in allowed.items()}
        assert durations.grown(now, allowed) == []
        now["c.py"] *= 1.4
        now["quick.py"] = slower * 3.0
        assert durations.grown(now, allowed) == []
        now["b.py"] *= 1.6
        now["new.py"] = slower * 6.0
        assert [line.split(":")[0] for line in durations.grown(now, allowed)] == ["b.py", "new.py"]


def test_a_run_prints_its_slowest_tests_and_folders_and_writes_its_files(tmp_path):
    """The seconds of child processes count; a name may be as long as a file."""
    burn = "import time\\nend = time.process_time() + {}\\nwhile time.process_time() < end: pass"
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "test_child.py").write_text(
        f"import subprocess, sys\ncode = '''{burn.format(0.6)}'''\n"
        "def test_it():\n    subprocess.run([sys.executable, '-c', code])\n")
    (tmp_path / "test_own.py").write_text(
        "import pytest\n@pytest.mark.parametrize('text', [''], ids=['a' * 200_000])\n"
        f"def test_it(text):\n    exec('''{burn.format(0.3)}''')\n")
    code = ("import sys, pathlib, pytest, tools.durations as d; d.LAST = pathlib.Path('last.csv'); "
            "sys.exit(pytest.main(['-q', '-p', 'no:cacheprovider', '-c', '/dev/null', '.'], plugins=[d]))")
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True,
                          text=True, check=False, env={"PYTHONPATH": str(ROOT), "PATH": ""})
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout[done.stdout.index("seconds of a processor"):].splitlines()[1:]
    assert [line.split()[1] for line in lines[:2]] == ["deep/test_child.py::test_it",
                                                       f"test_own.py::test_it[{'a' * 200_000}]"]
    files = durations.read(tmp_path / "last.csv")
    assert files == {"deep/test_child.py": pytest.approx(0.65, abs=0.3), "test_own.py": pytest.approx(0.3, abs=0.2)}
    ticks = 0.02                # os.times counts in hundredths, at the begin and at the end
    assert files["deep/test_child.py"] >= 0.6 - ticks
    assert files["test_own.py"] >= 0.3 - ticks
