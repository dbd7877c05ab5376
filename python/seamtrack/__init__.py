"""Weld seam tracking in laser-stripe pictures.

>>> import seamtrack
>>> run = seamtrack.track("rec/frames", mm_per_px=0.073)     # doctest: +SKIP
>>> run.to_pandas()                                          # doctest: +SKIP

`track` takes a whole recording, `Session` the frames of a live camera one by one, `synth` makes recordings up, `kalman` has the filters
of four papers, `calib` turns pixels into millimetres, and `seamtrack.fleet` tracks thousands of recordings.
"""

from __future__ import annotations

from . import calib, kalman, synth
from ._native import Config, Estimate, Session, __version__
from ._run import Run, track
from .calib import Sensor

__all__ = [
    "Config",
    "Estimate",
    "Run",
    "Sensor",
    "Session",
    "__version__",
    "calib",
    "kalman",
    "synth",
    "track",
]
