"""What the tests share: the program, recordings of the repository, made-up ones."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

import seamtrack

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def program() -> Path:
    """The program that the Python package must agree with: built by `cargo build`, or named by SEAMTRACK_PROGRAM."""
    place = Path(os.environ.get("SEAMTRACK_PROGRAM", ROOT / "target" / "debug" / "seamtrack"))
    assert place.exists(), f"{place} is missing: run `cargo build`, or `make python-test`"
    return place


@pytest.fixture(scope="session")
def run_program(program: Path):
    def call(*arguments: object, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
        command = [str(program), *map(str, arguments)]
        return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)

    return call


@pytest.fixture(scope="session")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made-up recording of 30 frames, with its truth."""
    folder = tmp_path_factory.mktemp("short") / "butt"
    seamtrack.synth.write("A-butt", folder, seed=5, frames=30)
    return folder
