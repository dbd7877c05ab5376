"""The wheel in a clean environment."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

#: Most bytes of the wheel.
MOST_BYTES = 5_000_000

SNIPPET = """
import seamtrack
run = seamtrack.track("fixtures/demo-butt", mm_per_px=0.073)
table = run.to_pandas()
assert len(table) == len(run.to_arrow()) == len(run) > 10
import matplotlib
matplotlib.use("agg")
run.plot()
print(run)
"""


@pytest.fixture(scope="module")
def wheel(root) -> Path:
    wheels = sorted((root / "target" / "wheels").glob("seamtrack-*.whl"), key=lambda file: file.stat().st_mtime)
    assert wheels, "no wheel: run `make wheel`"
    return wheels[-1]


def test_the_wheel_is_small_and_serves_every_python_from_3_10_on(wheel):
    assert wheel.stat().st_size <= MOST_BYTES
    assert "-cp310-abi3-" in wheel.name


def test_a_clean_environment_runs_the_first_snippet(wheel, root, tmp_path):
    venv.create(tmp_path / "clean", with_pip=True)
    python = tmp_path / "clean" / "bin" / "python"
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"{wheel}[notebook]"]
    subprocess.run(install, check=True, env=environment, cwd=tmp_path)
    done = subprocess.run([python, "-c", SNIPPET], cwd=root, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stdout.startswith("<Run GOOD: Tracked on"), done.stdout + done.stderr
    assert sys.version_info >= (3, 10)
