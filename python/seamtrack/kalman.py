"""The filters and smoothers of four papers, on arrays.

Each class is a model with its noise parameters, as printed in its paper where they are not given. `filter` runs it over a measured
series and smooths the whole of it, `fit` finds the parameters under which the series is most likely. z is the unit of the measurements,
whatever it is; NaN is a missing measurement.

>>> import numpy as np
>>> from seamtrack import kalman
>>> y = 0.02 * np.arange(50.0) + np.random.default_rng(1).normal(0.0, 0.1, 50)
>>> filtered = kalman.ConstantVelocity().filter(y, period_s=0.04)
>>> filtered.smooth_x.shape
(50,)
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import filter_series, fit_series

__all__ = ["Adaptive", "ColouredMeasurement", "ColouredProcess", "ConstantVelocity", "Filtered", "Model"]

Floats = NDArray[np.float64]
M = TypeVar("M", bound="Model")


@dataclass(frozen=True, eq=False)
class Filtered:
    """A filtered and smoothed series; arrays of shape (n,), NaN where there is no value, as before the first state."""

    x: Floats
    """Filtered position [z]."""
    x_std: Floats
    """One σ of it [z]."""
    velocity: Floats
    """Filtered velocity [z/s]."""
    velocity_std: Floats
    """One σ of it [z/s]."""
    smooth_x: Floats
    """Smoothed position [z]."""
    smooth_x_std: Floats
    """One σ of it [z]."""
    innovation: Floats
    """Measured less predicted position [z]."""
    nis: Floats
    """Normalised innovation squared: 1 on average where the model is right."""
    weight: Floats
    """What a measurement counted for: 1 unless the gate weighed it down."""
    log_likelihood: float
    """Log-likelihood of the series under the model."""

    def __repr__(self) -> str:
        return f"<Filtered: {len(self.x)} measurements, log-likelihood {self.log_likelihood:.2f}>"


@dataclass(frozen=True)
class Model:
    """What the four models share; take one of them."""

    _name: ClassVar[str]
    _has_period: ClassVar[bool] = False

    def filter(
        self,
        y: ArrayLike,
        *,
        time_s: ArrayLike | None = None,
        period_s: float | None = None,
        second: ArrayLike | None = None,
        gate: bool = False,
        fixed_lag: int | None = None,
    ) -> Filtered:
        """Filters and smooths y [z], shape (n,).

        time_s: times [s], shape (n,), or period_s: the time between measurements [s]; one of them.
        second: the measured change since the measurement before [z], shape (n,), of `ColouredProcess` and `Adaptive`; taken from y
        where it is not given.
        gate: weigh down measurements beyond the 99 % point of χ² (`Adaptive` does so anyway).
        fixed_lag: smooth with so many later measurements only, at most 1000, instead of the whole series.

        Raises ValueError when the series is too short, shapes differ, or times do not rise.
        """
        z, stamps, other = _series(y, time_s, period_s, second)
        told = filter_series(self._name, self._numbers(stamps), z, stamps, other, gate, fixed_lag)
        return Filtered(**told)

    def fit(
        self: M,
        y: ArrayLike,
        *,
        time_s: ArrayLike | None = None,
        period_s: float | None = None,
        second: ArrayLike | None = None,
        gate: bool = False,
    ) -> M:
        """The model with the noise parameters under which the series is most likely; the search starts from this one's."""
        z, stamps, other = _series(y, time_s, period_s, second)
        numbers = self._numbers(stamps)
        fitted, _ = fit_series(self._name, numbers, z, stamps, other, gate)
        if self._has_period:
            fitted["period_s"] = numbers["period_s"]
        return dataclasses.replace(self, **fitted)

    def _numbers(self, stamps: Floats) -> dict[str, float]:
        numbers: dict[str, float] = dataclasses.asdict(self)
        if numbers.get("period_s", 0.0) is None:
            numbers["period_s"] = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 1.0
        return numbers


@dataclass(frozen=True)
class ConstantVelocity(Model):
    """Constant velocity under white noise: Zhang 2009."""

    _name: ClassVar[str] = "white"

    acceleration_variance: float = 0.01
    """Variance of the random acceleration [z²/s⁴]."""
    white_variance: float = 0.01
    """Variance of the measurement noise [z²]."""


@dataclass(frozen=True)
class ColouredMeasurement(Model):
    """Constant velocity under coloured and white measurement noise: Du 2022, the seam tracker's own."""

    _name: ClassVar[str] = "coloured-measurement"
    _has_period: ClassVar[bool] = True

    acceleration_variance: float = 0.01
    """Variance of the random acceleration [z²/s⁴]."""
    colour_drive_variance: float = 0.01
    """Variance that drives the coloured noise each period [z²]."""
    colour_coefficient: float = 0.5
    """Correlation of the coloured noise from one period to the next, -1 to 1."""
    white_variance: float = 5.0
    """Variance of the white noise [z²]."""
    period_s: float | None = None
    """The period that the coloured noise's numbers belong to [s]; the series' median step where it is None."""


@dataclass(frozen=True)
class ColouredProcess(Model):
    """Constant velocity under coloured process noise, the displacement measured too: the infrared paper."""

    _name: ClassVar[str] = "coloured-process"
    _has_period: ClassVar[bool] = True

    drive_variance: float = 0.0081
    """Variance that drives the coloured acceleration [z²/frame⁴]."""
    colour_coefficient: float = 0.5
    """Correlation of the acceleration from one frame to the next, -1 to 1."""
    position_variance: float = 5.0
    """Variance of the measured position [z²]."""
    displacement_variance: float = 5.0
    """Variance of the measured displacement [z²]."""
    period_s: float | None = None
    """The period that the numbers belong to [s]; the series' median step where it is None."""


@dataclass(frozen=True)
class Adaptive(Model):
    """Measurement noise learnt while filtering, the change measured too: the clad's width, Jiang 2016."""

    _name: ClassVar[str] = "adaptive"

    acceleration_variance: float = 0.001
    """Variance of the random acceleration [z²/s⁴]."""
    white_variance: float = 0.001_232
    """Variance of the measured width [z²] that the learning starts from: a mean absolute error of 0.028 mm."""


def _series(
    y: ArrayLike, time_s: ArrayLike | None, period_s: float | None, second: ArrayLike | None
) -> tuple[Floats, Floats, Floats | None]:
    z = _row("y", y)
    if (time_s is None) == (period_s is None):
        raise ValueError("give time_s or period_s, one of them")
    stamps: Floats = _row("time_s", time_s) if period_s is None else np.arange(len(z)) * np.float64(period_s)
    return z, stamps, None if second is None else _row("second", second)


def _row(name: str, values: ArrayLike | None) -> Floats:
    row = np.asarray(values, dtype=np.float64)
    if row.ndim != 1:
        raise ValueError(f"{name} is an array of shape (n,), got {row.shape}")
    return row
