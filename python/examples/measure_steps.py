"""What a step costs from Python, beside the same step in Rust; and two sessions in two threads beside one after the other.

`python measure_steps.py`: ratios within one run, in rounds by turns, since a machine's speed wanders.
"""

from __future__ import annotations

import statistics
import tempfile
import threading
import time
from pathlib import Path

import seamtrack

SCENE, FRAMES, ROUNDS = "A-butt", 200, 7


def follow(frames, times) -> list[float]:
    """Milliseconds of each step."""
    session = seamtrack.Session(mm_per_px=0.073)
    took = []
    for frame, time_s in zip(frames, times, strict=True):
        began = time.perf_counter()
        session.step(frame, time_s)
        took.append(1e3 * (time.perf_counter() - began))
    return took


def in_threads(count: int, frames, times) -> float:
    """Seconds that so many sessions take at once."""
    threads = [threading.Thread(target=follow, args=(frames, times)) for _ in range(count)]
    began = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - began


def main() -> None:
    folder = Path(tempfile.mkdtemp()) / "rec"
    seamtrack.synth.write(SCENE, folder, frames=FRAMES)
    frames, truth = seamtrack.synth.render(SCENE, frames=FRAMES)
    ratios, speedups = [], []
    for _ in range(ROUNDS):
        rust_ms = seamtrack.track(folder, mm_per_px=0.073).summary["timing"]["track_ms"]["p50"]
        python_ms = statistics.median(follow(frames, truth.time_s))
        ratios.append(python_ms / rust_ms)
        speedups.append(2 * in_threads(1, frames, truth.time_s) / in_threads(2, frames, truth.time_s))
        print(f"step: Rust {rust_ms:.3f} ms, Python {python_ms:.3f} ms, ratio {ratios[-1]:.3f}; two threads {speedups[-1]:.2f} x one")
    print(f"median: ratio {statistics.median(ratios):.3f}, two threads {statistics.median(speedups):.2f} x one")


if __name__ == "__main__":
    main()
