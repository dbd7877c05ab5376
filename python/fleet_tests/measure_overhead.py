"""Processor time of a fleet beside the tracking of its recordings, which a busy machine does not change: threads of one process.

`python measure_overhead.py [RECORDINGS] [FRAMES]`: the recordings are tracked once by `track` alone and once by `fleet.run`, by turns.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

import seamtrack
from seamtrack import fleet

RENDERED, ROUNDS = 4, 3


def main(recordings: int = 200, frames: int = 20) -> None:
    folder = Path(tempfile.mkdtemp())
    for number in range(RENDERED):
        seamtrack.synth.write("A-butt", folder / f"rendered{number}", seed=number + 1, frames=frames)
    names = [f"r{number:05d}" for number in range(recordings)]
    for number, name in enumerate(names):
        (folder / name).symlink_to(f"rendered{number % RENDERED}")
    (folder / "list.csv").write_text("\n".join(["input", *names]) + "\n")
    beside, alone = [], []
    for round_ in range(ROUNDS):
        began = time.process_time()
        for name in names:
            seamtrack.track(folder / name, mm_per_px=0.073)
        tracking = time.process_time() - began
        began = time.process_time()
        report = fleet.run(folder / "list.csv", folder / f"out{round_}", jobs=2, mm_per_px=0.073)
        assert report.is_complete
        beside.append(1e3 * (time.process_time() - began - tracking) / recordings)
        alone.append(1e3 * tracking / recordings)
        print(f"tracking {alone[-1]:.1f} ms, beside it {beside[-1]:.2f} ms of processor time a recording of {frames} frames")
    size = sum(file.stat().st_size for file in (folder / "out0").rglob("*.parquet"))
    print(f"median: {statistics.median(alone):.1f} ms and {statistics.median(beside):.2f} ms; {size / recordings / 1e3:.1f} kB written a recording")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
