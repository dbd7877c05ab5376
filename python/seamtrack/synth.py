"""Made-up recordings of which the truth is known.

>>> from seamtrack import synth
>>> frames, truth = synth.render("I-butt-heavy", seed=3, frames=2)
>>> frames.shape, frames.dtype.name
((2, 480, 640), 'uint8')
"""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._native import render_scene, scene_names, write_scene

__all__ = ["Rendered", "Truth", "render", "scenes", "write"]


class Truth(NamedTuple):
    """What is true in each frame; arrays of shape (frames,), NaN where there is no joint."""

    time_s: NDArray[np.float64]
    """Time stamps [s]."""
    u_px: NDArray[np.float64]
    """The seam's column [px]."""
    v_px: NDArray[np.float64]
    """The seam's row [px]."""
    gap_px: NDArray[np.float64]
    """The visible opening of a butt joint or of a V-groove's root [px]."""
    occluded: NDArray[np.bool_]
    """The seam is hidden, by a cover or under a tack weld."""


class Rendered(NamedTuple):
    """A made-up recording."""

    frames: NDArray[np.uint8]
    """Shape (frames, rows, columns)."""
    truth: Truth
    """What is true in them."""


def scenes() -> list[str]:
    """The names of the built-in scenes."""
    return scene_names()


def render(scene: str | os.PathLike[str], seed: int | None = None, frames: int | None = None) -> Rendered:
    """Renders a built-in scene, or the scenario of a TOML file, in memory.

    seed, frames: those of the scenario where they are not given. The same seed gives the same bytes on any machine.
    Raises ValueError when there is no such scene, OSError when the file cannot be read.
    """
    pictures, truth = render_scene(os.fspath(scene), seed, frames)
    return Rendered(pictures, Truth(**truth))


def write(
    scene: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    seed: int | None = None,
    frames: int | None = None,
    *,
    force: bool = False,
) -> None:
    """Writes the recording as `seamtrack synth` does: `frames/`, `truth.csv`, `scenario.toml`; whole or not at all.

    Raises ValueError when something stands at `folder`; force replaces an earlier recording.
    """
    write_scene(os.fspath(scene), os.fspath(folder), seed, frames, force)
