"""Many short recordings, of which a few are rendered and the others are links to them."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import seamtrack
from seamtrack import fleet

#: Recordings of a fleet, and frames of each.
RECORDINGS = int(os.environ.get("FLEET_RECORDINGS", "2000"))
FRAMES = int(os.environ.get("FLEET_FRAMES", "10"))
RENDERED = 8
SHARD_SIZE = 16


@pytest.fixture(scope="session")
def manifest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    for number in range(RENDERED):
        seamtrack.synth.write("A-butt", folder / f"rendered{number}", seed=number + 1, frames=FRAMES)
    names = []
    for number in range(RECORDINGS):
        name = f"r{number:05d}"
        (folder / name).symlink_to(f"rendered{number % RENDERED}")
        # Some that cannot be tracked: they are rows too.
        names.append("nowhere-" + name if number % 97 == 96 else name)
    (folder / "list.csv").write_text("\n".join(["input", *names]) + "\n")
    return folder / "list.csv"


def beside_ms(out: Path, seconds: float, processors: int) -> float:
    """Time of the processors beside the tracking, a recording [ms]."""
    work = pq.read_table(out / "recordings", columns=["seconds"])["seconds"].to_pylist()
    return 1e3 * (processors * seconds - sum(work)) / len(work)


@pytest.fixture(scope="session")
def undisturbed(manifest: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("local") / "out"
    began = time.perf_counter()
    report = fleet.run(manifest, out, shard_size=SHARD_SIZE, jobs=2, mm_per_px=0.073)
    seconds = time.perf_counter() - began
    print(f"\nlocal, 2 threads: {seconds:.1f} s, {beside_ms(out, seconds, 2):.2f} ms a recording beside the tracking\n{report}")
    assert report.is_complete
    return out


def same_frames(out: Path, undisturbed: Path) -> bool:
    files = sorted(file.name for file in (undisturbed / "frames").iterdir())
    return all((out / "frames" / name).read_bytes() == (undisturbed / "frames" / name).read_bytes() for name in files)
