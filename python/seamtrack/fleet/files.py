"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable
from pathlib import Path

#: The end of names of files that are being written.
PART = ".part"


def write_whole(target: Path, write: Callable[[Path], object]) -> None:
    """`write` fills a file beside `target`, which then takes its place in one step; also when the power fails."""
    part = target.with_name(f".{target.name}.{uuid.uuid4().hex}{PART}")
    try:
        write(part)
        with open(part, "rb") as file:
            os.fsync(file.fileno())
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)
    folder = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
