"""The notebook runs as it stands."""

from __future__ import annotations

import runpy

import pytest


def test_the_notebook_runs_and_shows_its_pictures(root):
    pytest.importorskip("nbclient")
    shown = runpy.run_path(str(root / "python" / "examples" / "run_notebook.py"))["pictures"]()
    documented = sorted((root / "docs" / "pictures").glob("python-*.png"))
    assert len(shown) == len(documented) == 3
    assert all(picture.startswith(b"\x89PNG") and len(picture) > 10_000 for picture in shown)
