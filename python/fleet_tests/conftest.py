"""Many short recordings, of which a few are rendered and the others are links to them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import seamtrack

#: Recordings of a fleet, and frames of each.
RECORDINGS = int(os.environ.get("FLEET_RECORDINGS", "2000"))
FRAMES = int(os.environ.get("FLEET_FRAMES", "10"))
RENDERED = 8


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
