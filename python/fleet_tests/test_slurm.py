"""A real Slurm, of this machine alone: an array with a task killed. Skipped where Slurm is not installed (`apt-get install slurmctld slurmd
slurm-client munge`) or its daemons may not be started, which only root may."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import SHARD_SIZE, same_frames

from seamtrack import fleet
from seamtrack.fleet.plans import shards_done

DAEMONS = ["munged", "slurmctld", "slurmd"]


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def configuration(folder: Path) -> str:
    host = socket.gethostname()
    return f"""
ClusterName=seamtrack
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
StateSaveLocation={folder}
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs={min(2, os.cpu_count() or 1)} State=UNKNOWN
PartitionName=weld Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@pytest.fixture(scope="module")
def slurm() -> Iterator[dict[str, str]]:
    """The environment of a Slurm's commands, on this machine alone, without systemd."""
    if os.geteuid() != 0 or not all(shutil.which(daemon, path="/usr/sbin:/usr/bin:/sbin") for daemon in DAEMONS):
        pytest.skip("Slurm is not installed, or this is not root: the array was not run by a real Slurm")
    # A socket's path is at most 107 bytes long.
    folder = Path(f"/tmp/seamtrack-slurm-{os.getpid()}")
    folder.mkdir(mode=0o755)
    (folder / "key").write_bytes(os.urandom(1024))
    (folder / "key").chmod(0o600)
    (folder / "slurm.conf").write_text(configuration(folder))
    environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf"), "PATH": os.environ["PATH"] + ":/usr/sbin"}
    munge = [f"--{name}={folder}/{file}" for name, file in [
        ("key-file", "key"), ("socket", "munge.sock"), ("pid-file", "munged.pid"), ("log-file", "munged.log"), ("seed-file", "seed"),
    ]]
    try:
        for command in [["munged", *munge, "--force"], ["slurmctld", "-c"], ["slurmd"]]:
            subprocess.run(command, env=environment, check=True, capture_output=True)
        deadline = time.monotonic() + 30
        while "idle" not in subprocess.run(["sinfo"], env=environment, capture_output=True, text=True).stdout:
            assert time.monotonic() < deadline, (folder / "slurmctld.log").read_text()
            time.sleep(0.1)
        yield environment
    finally:
        for pid in folder.glob("*.pid"):
            subprocess.run(["kill", pid.read_text().strip()], check=False)
        time.sleep(1)
        shutil.rmtree(folder, ignore_errors=True)


def test_a_task_that_slurm_ends_is_requeued_and_each_recording_is_there_once(manifest, undisturbed, slurm, tmp_path):
    out = tmp_path / "out"
    began = time.perf_counter()
    fleet.plan(manifest, out, shard_size=SHARD_SIZE, mm_per_px=0.073)
    script = fleet.write_sbatch(out, tasks=4)

    def ask(*command: object) -> str:
        return subprocess.run(list(map(str, command)), env=slurm, capture_output=True, text=True, check=True).stdout

    job = ask("sbatch", "--parsable", script).strip()
    while len(shards_done(out)) < 4:
        time.sleep(0.05)
    ask("scancel", "--signal=KILL", "--full", f"{job}_1")
    while f"{job}_1 " in ask("squeue", "--noheader", "--format=%i ", "--states=RUNNING"):
        time.sleep(0.1)
    left = len(shards_done(out))
    ask("scontrol", "requeue", f"{job}_1")
    while ask("squeue", "--noheader", "--job", job).strip():
        time.sleep(0.5)
    report = fleet.check(out)
    print(f"\nSlurm, a task killed when {left} shards were there: {time.perf_counter() - began:.1f} s\n{report}")
    assert report.is_complete and same_frames(out, undisturbed)
