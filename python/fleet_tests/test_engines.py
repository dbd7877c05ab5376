"""Nodes and processes that are killed in the middle: each recording exactly once, frames as of an undisturbed run."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from conftest import SHARD_SIZE, beside_ms, same_frames
from seamtrack import fleet
from seamtrack.fleet.plans import shards_done

KILLS = 10


def command(manifest: Path, out: Path, *more: object) -> list[str]:
    arguments = ["run", manifest, "-o", out, "--shard-size", SHARD_SIZE, "--mm-per-px", 0.073, "--quiet", *more]
    return [sys.executable, "-m", "seamtrack.fleet", *map(str, arguments)]


def test_a_process_killed_ten_times_leaves_each_recording_once(manifest, undisturbed, tmp_path):
    out, seed = tmp_path / "out", random.Random(1)
    finished: dict[str, int] = {}
    for _ in range(KILLS):
        before = len(shards_done(out))
        process = subprocess.Popen(command(manifest, out, "--jobs", 2), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 120
        while len(shards_done(out)) < before + 1 and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(seed.uniform(0.0, 1.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
        for file in out.glob("*/*.parquet"):
            done = file.parent.name == "recordings" or (out / "recordings" / file.name).exists()
            if done:
                assert finished.setdefault(str(file), file.stat().st_mtime_ns) == file.stat().st_mtime_ns
    done = subprocess.run(command(manifest, out), capture_output=True, text=True, check=True)
    print(f"\nkilled {KILLS} times:\n{done.stdout}")
    assert all(Path(file).stat().st_mtime_ns == stamp for file, stamp in finished.items())
    assert "each recording exactly once" in done.stdout and same_frames(out, undisturbed)


def test_ray_loses_a_node_and_no_recording(manifest, undisturbed, tmp_path):
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    lost = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    ray.init(address=cluster.address, log_to_driver=False)
    out = tmp_path / "out"
    killed = threading.Event()

    def kill() -> None:
        recordings = len(manifest.read_text().splitlines()) - 1
        while not out.exists() or len(shards_done(out)) * SHARD_SIZE < recordings // 3:
            time.sleep(0.05)
        cluster.remove_node(lost, allow_graceful=False)
        killed.set()
        cluster.add_node(num_cpus=1)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    try:
        report = fleet.run(manifest, out, engine="ray", shard_size=SHARD_SIZE, mm_per_px=0.073)
    finally:
        ray.shutdown()
        cluster.shutdown()
    print(f"\nRay, a node killed ({killed.is_set()}):\n{report}")
    assert killed.is_set() and report.is_complete and same_frames(out, undisturbed)


def test_ray_undisturbed_takes_little_longer_than_threads(manifest, undisturbed, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    out = tmp_path / "out"
    began = time.perf_counter()
    try:
        report = fleet.run(manifest, out, engine="ray", shard_size=SHARD_SIZE, mm_per_px=0.073)
    finally:
        ray.shutdown()
    seconds = time.perf_counter() - began
    print(f"\nRay, 2 workers: {seconds:.1f} s, {beside_ms(out, seconds, 2):.2f} ms a recording beside the tracking\n{report}")
    assert report.is_complete and same_frames(out, undisturbed)


def test_an_array_with_a_task_killed_is_gone_on_with(manifest, undisturbed, tmp_path):
    """As Slurm does it: tasks of the sbatch file, one ended in the middle and requeued."""
    out = tmp_path / "out"
    fleet.plan(manifest, out, shard_size=SHARD_SIZE, mm_per_px=0.073)
    script = fleet.write_sbatch(out, tasks=2)

    def task(number: int) -> subprocess.Popen[bytes]:
        environment = {**os.environ, "SLURM_ARRAY_TASK_ID": str(number)}
        return subprocess.Popen(["bash", str(script)], env=environment, stdout=subprocess.DEVNULL)

    tasks = [task(0), task(1)]
    while len(shards_done(out)) < 4:
        time.sleep(0.02)
    tasks[1].kill()
    tasks[1].wait()
    tasks[1] = task(1)
    assert [one.wait() for one in tasks] == [0, 0]
    report = fleet.check(out)
    print(f"\narray, a task killed:\n{report}")
    assert report.is_complete and same_frames(out, undisturbed)
