"""Runs the notebook and writes its pictures: `python run_notebook.py docs/pictures` makes those of docs/python.md."""

from __future__ import annotations

import base64
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).with_name("first_steps.ipynb")


def pictures() -> list[bytes]:
    """The PNG pictures of the notebook's cells, in order. Raises CellExecutionError when a cell fails."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = [output["data"] for output in outputs if output["output_type"] in ("display_data", "execute_result")]
    return [base64.b64decode(data["image/png"]) for data in shown if "image/png" in data]


if __name__ == "__main__":
    for number, picture in enumerate(pictures(), start=1):
        (Path(sys.argv[1]) / f"python-{number}.png").write_bytes(picture)
