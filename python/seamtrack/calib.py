"""Pixels to millimetres: `load` a calibration, or give one scale.

>>> from seamtrack import calib
>>> sensor = calib.Sensor(0.073)
>>> points, jacobians = sensor.to_plane([[100.0, 50.0]])
>>> points.round(3).tolist()
[[7.3, 3.65]]
"""

from __future__ import annotations

import os

from ._native import Sensor

__all__ = ["Sensor", "load"]


def load(path: str | os.PathLike[str]) -> Sensor:
    """The sensor of a `calibration.toml`, as `seamtrack calibrate` wrote it: camera and laser plane, or one scale.

    `load(path).to_plane(uv)` gives points in the laser's plane [mm] and their Jacobians [mm/px].
    Raises OSError when the file cannot be read, ValueError when it is no calibration.
    """
    return Sensor.read(path)
