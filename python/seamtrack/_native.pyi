"""The native part of seamtrack."""

from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, Unpack

from ._keys import Keys

__all__ = [
    "Config",
    "Estimate",
    "Recording",
    "Sensor",
    "Session",
    "__version__",
    "filter_series",
    "fit_series",
    "model_parameters",
    "render_scene",
    "scene_names",
    "track_recording",
    "value_columns",
    "write_scene",
]
__version__: str

_Path = str | PathLike[str]
_Floats = NDArray[np.float64]

@final
class Config:
    """The configuration of the tracker: the keys of `seamtrack config --print` as keywords, checked, never changed.

    >>> import seamtrack
    >>> config = seamtrack.Config(joint="butt", mm_per_px=0.073)
    >>> config.replace(joint="lap")
    Config(joint="lap", mm_per_px=0.073)

    Raises ValueError for an unknown key and for a number out of its range.
    """

    def __new__(cls, **keys: Unpack[Keys]) -> Self: ...
    @staticmethod
    def read(path: _Path) -> Config:
        """Reads a TOML file. Raises OSError when it cannot be read, ValueError when it is wrong."""
    def replace(self, **keys: Unpack[Keys]) -> Config:
        """The same configuration with other values of some keys."""
    def to_dict(self) -> dict[str, Any]:
        """All keys with their values."""
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Sensor:
    """What a pixel is: `Sensor()` knows nothing, `Sensor(0.073)` is one scale [mm/px], `Sensor.read(file)` a calibration.

    `toml` is the text of a calibration file, `source` where the knowledge comes from.
    """

    def __new__(
        cls, mm_per_px: float | None = None, *, toml: str | None = None, source: str | None = None
    ) -> Self: ...
    @staticmethod
    def read(path: _Path) -> Sensor:
        """Reads a calibration that `seamtrack calibrate` wrote: camera and laser plane, or a scale.

        Raises OSError when the file cannot be read, ValueError when it is no calibration.
        """
    def cropped(self, at: tuple[int, int], size: tuple[int, int]) -> Sensor:
        """The sensor of pictures that were cut out of the calibrated ones.

        at: their first column and row in the calibrated picture; size: their columns and rows [px]. Raises ValueError when they
        reach beyond the calibrated picture.
        """
    @property
    def kind(self) -> Literal["pixels", "scale", "plane"]:
        """What is known."""
    @property
    def source(self) -> str:
        """Where the knowledge comes from."""
    @property
    def mm_per_px(self) -> float | None:
        """The scale [mm/px], if there is one."""
    def to_plane(
        self, uv: ArrayLike, *, stripe: Literal["horizontal", "vertical"] = "horizontal"
    ) -> tuple[_Floats, _Floats]:
        """Points of the laser's plane that pixels show: see `seamtrack.calib.to_plane`.

        uv: shape (n, 2), columns u and v [px]. Returns points of shape (n, 2), lateral and height [mm], and Jacobians of shape
        (n, 2, 2), d(lateral, height)/d(u, v) [mm/px]; NaN where a pixel's ray does not meet the plane. Without a scale the
        lengths are pixels. `stripe` is how the stripe runs, of one scale.
        """
    def to_pixel(
        self, points: ArrayLike, *, stripe: Literal["horizontal", "vertical"] = "horizontal"
    ) -> _Floats:
        """Pixels (u, v) that show points (lateral, height) [mm] of shape (n, 2): the inverse of `to_plane`."""
    def calibration_covariance(self, uv: ArrayLike) -> _Floats:
        """Covariance of (lateral, height) [mm²], shape (n, 2, 2), that the calibration's own error makes: the same in all frames."""
    def is_calibrated(self, uv: ArrayLike) -> NDArray[np.bool_]:
        """Whether the pixels, shape (n, 2), lie where stripes were seen when the sensor was calibrated."""
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[float | None], dict[str, Any]]: ...

@final
class Estimate:
    """What the tracker says of one frame. What it does not know is None."""

    def __new__(
        cls,
        status: str,
        u_px: float | None = None,
        v_px: float | None = None,
        std_px: float | None = None,
        std_across_px: float | None = None,
        lateral_mm: float | None = None,
        height_mm: float | None = None,
        observation: str = "",
        nis: float | None = None,
        kcf_u_px: float | None = None,
        kcf_v_px: float | None = None,
        psr: float | None = None,
        gap_px: float | None = None,
        mismatch_px: float | None = None,
        repeated: bool = False,
    ) -> Self: ...
    @property
    def status(self) -> str:
        """seeking, tracked, coasting (a prediction with a growing σ) or lost."""
    @property
    def u_px(self) -> float | None:
        """The seam's column [px]; None unless tracked or coasting."""
    @property
    def v_px(self) -> float | None:
        """The seam's row [px]."""
    @property
    def std_px(self) -> float | None:
        """One σ along the stripe [px]."""
    @property
    def std_across_px(self) -> float | None:
        """One σ across the stripe [px]."""
    @property
    def lateral_mm(self) -> float | None:
        """The seam in the laser's plane along the stripe [mm]; None without a scale."""
    @property
    def height_mm(self) -> float | None:
        """The same across it [mm]; with a calibrated plane it grows towards the camera."""
    @property
    def observation(self) -> str:
        """What became of the frame's measurement, in a word of the program's trace.csv."""
    @property
    def nis(self) -> float | None:
        """Normalised innovation squared of the measurement."""
    @property
    def kcf_u_px(self) -> float | None:
        """The correlation filter's own peak, column [px]."""
    @property
    def kcf_v_px(self) -> float | None:
        """The correlation filter's own peak, row [px]."""
    @property
    def psr(self) -> float | None:
        """Peak-to-sidelobe ratio of its response."""
    @property
    def gap_px(self) -> float | None:
        """Gap of a butt joint, shadow of a lap joint, along the stripe [px]."""
    @property
    def mismatch_px(self) -> float | None:
        """By how much the stripe behind the seam has the larger coordinate across it [px]."""
    @property
    def repeated(self) -> bool:
        """The frame equals its predecessor byte for byte."""
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Session:
    """Finds the seam and follows it from frame to frame, as a camera gives them.

    >>> import seamtrack
    >>> frames, truth = seamtrack.synth.render("A-butt", frames=30)
    >>> session = seamtrack.Session(seamtrack.Sensor(0.073), joint="auto")
    >>> for frame, time_s in zip(frames, truth.time_s):
    ...     estimate = session.step(frame, time_s)
    >>> estimate.status, session.joint["kind"]
    ('tracked', 'butt')

    sensor: what a pixel is. config, keys: the configuration. white: the 16-bit grey that becomes 255; without it the bit depth
    (8, 10, 12, 14, 16) that frames have needed so far. A session runs without the GIL, so that several run at once in threads;
    calls of one session wait for each other.
    """

    def __new__(
        cls,
        sensor: Sensor | None = None,
        *,
        config: Config | None = None,
        white: int | None = None,
        **keys: Unpack[Keys],
    ) -> Self: ...
    def step(self, frame: NDArray[np.uint8] | NDArray[np.uint16], time_s: float) -> Estimate:
        """Takes the next frame, shape (rows, columns), recorded at time_s [s]; strided arrays and views are fine.

        A time that is no number or not later than the one before makes the frame a miss ("bad-stamp").
        Raises TypeError for anything but a 2-D array of uint8 or uint16, ValueError when the frames' size changes.
        """
    def miss(self, time_s: float) -> Estimate:
        """Says that the frame of time_s [s] could not be read: the filter predicts through it."""
    @property
    def joint(self) -> dict[str, Any] | None:
        """The joint found last: kind, frame, reason, doubt, contradicted_by."""
    @property
    def stripe(self) -> Literal["horizontal", "vertical"] | None:
        """How the stripe runs; None before one was seen."""
    @property
    def white(self) -> int | None:
        """The 16-bit grey that becomes 255; None before a frame of 16 bits came."""
    @property
    def config(self) -> Config:
        """The configuration."""
    @property
    def sensor(self) -> Sensor:
        """What a pixel is."""

@final
class Recording:
    """The native result of tracking a recording."""

    def __len__(self) -> int: ...
    @property
    def summary(self) -> dict[str, Any]: ...
    @property
    def verdict(self) -> tuple[str, str, list[str], list[str]]: ...
    @property
    def notes(self) -> list[str]: ...
    def columns(self) -> dict[str, Any]: ...
    def csv(self) -> bytes: ...

def track_recording(
    input: _Path,
    *,
    sensor: Sensor | None = None,
    config: Config | None = None,
    truth: _Path | None = None,
    frames: str | None = None,
    origin: str = "first",
    max_unavailable: float = 5.0,
    tolerance_mm: float | None = None,
    **keys: Unpack[Keys],
) -> Recording: ...
def value_columns() -> list[str]: ...
def scene_names() -> list[str]: ...
def render_scene(
    scene: str, seed: int | None = None, frames: int | None = None
) -> tuple[NDArray[np.uint8], dict[str, Any]]: ...
def write_scene(
    scene: str, folder: _Path, seed: int | None = None, frames: int | None = None, force: bool = False
) -> None: ...
def model_parameters(model: str) -> dict[str, float]: ...
def filter_series(
    model: str,
    parameters: dict[str, float],
    z: _Floats,
    time_s: _Floats,
    second: _Floats | None = None,
    gate: bool = False,
    fixed_lag: int | None = None,
) -> dict[str, Any]: ...
def fit_series(
    model: str,
    parameters: dict[str, float],
    z: _Floats,
    time_s: _Floats,
    second: _Floats | None = None,
    gate: bool = False,
) -> tuple[dict[str, float], float]: ...
