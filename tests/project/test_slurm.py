"""The array job of docs/farm.md on a Slurm of its own: `make test-slurm`, not part of `make test`."""

import itertools
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import ExitStack

import pytest

from support.checkout import ROOT
from support.synthetic import make_files
from tools import slurm

COUNT, TASKS = 12, 4
CONVERT = f"{sys.executable} {ROOT} convert"        # on the bpy module, what Blender's executable does in the manual
ENDED = {"COMPLETED", "FAILED", "CANCELLED", "NODE_FAIL", "TIMEOUT"}


class Farm:
    """Slurm and the folder in which jobs run."""

    def __init__(self, environment, folder):
        self._environment, self.folder = environment, folder

    def ask(self, *command):
        done = subprocess.run(command, env=self._environment, cwd=self.folder, capture_output=True, text=True,
                              check=False, timeout=60)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    def submit(self, script, *options):
        (self.folder / "job.sh").write_text(script)
        return self.ask("sbatch", "--parsable", "--output=%A_%a.out", *options, "job.sh")

    def about(self, task):
        words = self.ask("scontrol", "--oneliner", "show", "job", task).split()
        return dict(word.split("=", 1) for word in words if "=" in word)

    def wait(self, condition, seconds=300):
        end = time.monotonic() + seconds
        while not condition():
            said = "\n".join(path.read_text() for path in self.folder.glob("*.out"))
            assert time.monotonic() < end, f"{self.ask('squeue')}\n{said}"
            time.sleep(0.05)

    def end_of(self, task):
        self.wait(lambda: self.about(task)["JobState"] in ENDED)
        return self.about(task)["JobState"]

    def said(self, task):
        return (self.folder / f"{task}.out").read_text()


@pytest.fixture(scope="module")
def engine():
    with ExitStack() as stack:
        try:
            environment = stack.enter_context(slurm.running())
        except slurm.CannotRunError as error:
            pytest.skip(str(error))
        yield environment


@pytest.fixture
def farm(engine, tmp_path):
    (tmp_path / "measurements").mkdir()
    make_files(tmp_path / "measurements", COUNT)
    return Farm(engine, tmp_path)


@pytest.fixture
def script():
    """The batch script that docs/farm.md tells users to submit."""
    found = re.search(r"^```bash\n(#!/bin/bash\n#SBATCH.*?)^```", (ROOT / "docs" / "farm.md").read_text(), re.S | re.M)
    assert found[1].count("blender --command measured_brdf convert") == 1
    return found[1].replace("blender --command measured_brdf convert", CONVERT)


def materials_in(bpy, library):
    """What a library holds: sorted tuples of a name, the result of the fit, and the shader."""
    from measured_brdf.addon.core import material as materials
    from measured_brdf.addon.core import node_group

    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(library), link=False) as (source, target):
        names = list(source.materials)
        target.materials = source.materials
    found = []
    for name, item in zip(names, target.materials, strict=True):
        about = item.measured_brdf
        shader = node_group.script_node(materials.group_node(item).node_tree).bytecode
        found.append((name, about.name_of_data, about.digest, about.coefficients, about.bytes, about.rmse,
                      about.asset_key, shader))
    return sorted(found)


def test_an_array_job_with_a_task_killed_and_requeued_makes_what_one_process_makes(farm, script, blender):
    job = farm.submit(script)
    second, fits = f"{job}_2", farm.folder / f"library-2of{TASKS}.fits"
    farm.wait(lambda: list(fits.glob("*.npz")))
    process = int(re.search(r"process (\d+) on ", (farm.folder / f"library-2of{TASKS}.blend.lock").read_text())[1])
    os.killpg(os.getpgid(process), signal.SIGKILL)          # script, conversion and workers, as when a machine fails
    assert farm.end_of(second) == "FAILED"
    kept = {path.name: path.stat().st_mtime_ns for path in fits.glob("*.npz")}
    assert 0 < len(kept) < COUNT // TASKS
    assert not (farm.folder / f"library-2of{TASKS}.blend").exists()

    farm.ask("scontrol", "requeue", second)
    farm.wait(lambda: farm.about(second)["JobState"] not in ENDED)
    assert [farm.end_of(f"{job}_{task}") for task in range(1, TASKS + 1)] == ["COMPLETED"] * TASKS
    assert farm.about(second)["Restarts"] == "1"
    again = {path.name: path.stat().st_mtime_ns for path in fits.glob("*.npz")}
    assert len(again) == COUNT // TASKS
    assert kept.items() <= again.items()                    # not fitted a second time

    subprocess.run([*CONVERT.split(), "measurements", "-o", "whole.blend"], cwd=farm.folder, capture_output=True,
                   check=True)
    whole = materials_in(blender, farm.folder / "whole.blend")
    shards = [materials_in(blender, farm.folder / f"library-{task}of{TASKS}.blend") for task in range(1, TASKS + 1)]
    assert [len(shard) for shard in shards] == [COUNT // TASKS] * TASKS
    assert sorted(itertools.chain(*shards)) == whole
    assert len({digest for _, _, digest, *_ in whole}) == COUNT
    left = {path.name for path in farm.folder.iterdir() if path.suffix not in (".out", ".blend", ".fits")}
    assert left == {"measurements", "job.sh", "blender_assets.cats.txt"}


def test_of_two_tasks_that_write_the_same_library_the_second_says_so(farm, script, blender):
    script = script.replace(f"--shard $SLURM_ARRAY_TASK_ID/{TASKS} ", "")
    first = farm.submit(script, "--array=1")
    farm.wait(lambda: list(farm.folder.glob("library.fits/*.npz")))
    farm.ask("scontrol", "suspend", f"{first}_1")           # it has the library until the other has ended
    holder = (farm.folder / "library.blend.lock").read_text()
    assert re.fullmatch(r"process \d+ on .+", holder)
    second = farm.submit(script, "--array=1")
    assert farm.end_of(f"{second}_1") == "FAILED"
    assert farm.about(f"{second}_1")["ExitCode"] == "1:0"
    assert (f"error: {farm.folder / 'library.blend'}: another process is writing it ({holder}); try again when it is "
            f"done") in farm.said(f"{second}_1")
    farm.ask("scontrol", "resume", f"{first}_1")
    assert farm.end_of(f"{first}_1") == "COMPLETED", farm.said(f"{first}_1")
    assert len(materials_in(blender, farm.folder / "library.blend")) == COUNT
    third = farm.submit(script, "--array=1")                # now that it is done
    assert farm.end_of(f"{third}_1") == "COMPLETED"
    assert farm.said(f"{third}_1").count("up to date") == COUNT
