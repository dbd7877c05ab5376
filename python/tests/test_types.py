"""The package is typed, and the types are true."""

from __future__ import annotations

import subprocess
import sys


def call(place, *arguments):
    command = [sys.executable, "-m", *map(str, arguments)]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_is_content(root):
    settings = ["--strict", "--config-file", root / "pyproject.toml", "--cache-dir", root / "target" / "mypy"]
    call(root / "python", "mypy", *settings, "-p", "seamtrack")


def test_the_stub_is_that_of_the_native_part(root, tmp_path):
    # Where the installed package is found, and not the sources.
    call(tmp_path, "mypy.stubtest", "seamtrack._native", "--mypy-config-file", root / "pyproject.toml")
