"""A Slurm on this machine for as long as a command runs: ``python -m tools.slurm COMMAND ...``, as root on Debian.

It has one node, on the loopback interface. Its key, configuration, state and log are in a temporary folder, not in /etc
or /var; `sbatch` and the others find them by the variable SLURM_CONF. The exit code is that of the command, or 77 where
Slurm cannot run. Where it is not installed, the packages are, and stay.
"""

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

PACKAGES = ("slurm-wlm", "munge")
CPUS = 4                    # that the node claims, however many the machine has: four tasks at once
_CANNOT_RUN = 77            # the exit code by which Automake and others recognise a skipped test
_NO_SERVICES = Path("/usr/sbin/policy-rc.d")        # Debian asks it before a package starts its services
_WAIT = 60                  # s, for what takes seconds
_CONFIGURATION = """\
ClusterName=farm
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmctldPort={controller_port}
SlurmdPort={node_port}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
# a requeued job waits until the credential of its first run has expired; after 120 s by default
AuthInfo=socket={folder}/munge.socket,cred_expire=5
KillWait=2
MinJobAge=3600
SchedulerParameters=sched_interval=1,bf_interval=1
StateSaveLocation={folder}/controller
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdSpoolDir={folder}/node
SlurmdPidFile={folder}/slurmd.pid
PlugStackConfig={folder}/plugstack.conf
# nothing that needs control groups or MPI
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 CPUs={cpus}
PartitionName=farm Nodes=node Default=YES MaxTime=INFINITE State=UP
"""


class CannotRunError(RuntimeError):
    """This machine cannot run Slurm; the message says why."""


@contextmanager
def running():
    """Start Slurm; at the end cancel its jobs, stop it, and remove its folder.

    Yields
    ------
    dict of str
        The environment in which `sbatch`, `scontrol` and the others talk to it.

    Raises
    ------
    CannotRunError
    """
    _install()
    with tempfile.TemporaryDirectory(prefix="slurm_") as name, ExitStack() as stack:
        folder = Path(name)
        folder.chmod(0o755)                 # munged requires that everybody can reach its socket
        environment = _configure(folder)
        daemons = [["munged", "--foreground", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                    f"--pid-file={folder}/munged.pid", f"--seed-file={folder}/munge.seed", f"--log-file={folder}/log"],
                   ["slurmctld", "-D", "-c"],
                   ["slurmd", "-D", "-c", "-N", "node"]]
        with open(folder / "log", "ab") as log:
            for command in daemons:
                stack.enter_context(_daemon(command, environment, log))
                if command[0] == "munged":
                    _wait_until((folder / "munge.socket").exists, folder)
        _wait_until(lambda: _ask(environment, "sinfo", "--noheader", "--format=%T") == "idle", folder)
        try:
            yield environment
        finally:
            _ask(environment, "scancel", "--user=root")
            _wait_until(lambda: _ask(environment, "squeue", "--noheader") == "", folder)


def _install():
    if os.geteuid() != 0:
        raise CannotRunError("Slurm's daemons need root")
    if all(map(shutil.which, ("munged", "slurmctld", "slurmd", "sbatch"))):
        return
    if not shutil.which("apt-get"):
        raise CannotRunError(f"Slurm is not installed, and this is not Debian, of which it would be installed "
                             f"({', '.join(PACKAGES)})")
    ours = not _NO_SERVICES.exists()
    if ours:                                # keep packages from starting their daemons
        _NO_SERVICES.write_text("#!/bin/sh\nexit 101\n")
        _NO_SERVICES.chmod(0o755)
    try:
        for arguments in (["update"], ["install", "--yes", "--no-install-recommends", *PACKAGES]):
            done = subprocess.run(["apt-get", "--quiet", *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, check=False, env=os.environ | {"DEBIAN_FRONTEND": "noninteractive"})
            if done.returncode:
                raise CannotRunError(f"apt-get {' '.join(arguments)} failed:\n{done.stdout.strip()}")
    finally:
        if ours:
            _NO_SERVICES.unlink()


def _configure(folder):
    """Write key and configuration: the environment that names them."""
    key = folder / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(os.urandom(1024))
    for name in ("controller", "node"):
        (folder / name).mkdir()
    (folder / "plugstack.conf").touch()
    with socket.socket() as first, socket.socket() as second:
        first.bind(("127.0.0.1", 0))
        second.bind(("127.0.0.1", 0))
        ports = {"controller_port": first.getsockname()[1], "node_port": second.getsockname()[1]}
    host = socket.gethostname().partition(".")[0]
    configuration = folder / "slurm.conf"
    configuration.write_text(_CONFIGURATION.format(folder=folder, host=host, cpus=CPUS, **ports))
    return os.environ | {"SLURM_CONF": str(configuration)}


@contextmanager
def _daemon(command, environment, log):
    """Run a daemon in a session of its own, so that Ctrl-C reaches it only after its jobs are cancelled."""
    process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                               start_new_session=True)
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(_WAIT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _ask(environment, *command):
    """What a command prints; None where it fails."""
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=_WAIT)
    return done.stdout.strip() if done.returncode == 0 else None


def _wait_until(condition, folder):
    end = time.monotonic() + _WAIT
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError(f"Slurm does not do what it should:\n{(folder / 'log').read_text()[-4000:]}")
        time.sleep(0.1)


def main():
    """Run a command with Slurm: its exit code."""
    if len(sys.argv) == 1:
        print("usage: python -m tools.slurm COMMAND ...", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))        # by way of what stops Slurm
    try:
        with running() as environment:
            return subprocess.run(sys.argv[1:], env=environment, check=False).returncode
    except CannotRunError as error:
        print(f"error: {error}", file=sys.stderr)
        return _CANNOT_RUN


if __name__ == "__main__":
    sys.exit(main())
