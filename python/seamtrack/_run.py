"""A whole recording: tracked, and what came of it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _picture
from ._native import Config, Recording, Sensor, track_recording

if TYPE_CHECKING:
    import pandas
    import pyarrow
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from ._keys import Keys

Path = str | os.PathLike[str]

#: Columns of path.csv that are 0, 1 or nothing.
FLAGS = ("template_updated", "calibrated")
#: Columns of path.csv that are text.
TEXTS = ("file", "status")


def track(
    input: Path,
    *,
    sensor: Sensor | None = None,
    config: Config | None = None,
    truth: Path | None = None,
    frames: str | None = None,
    origin: Literal["first", "centre"] | float = "first",
    max_unavailable: float = 5.0,
    tolerance_mm: float | None = None,
    **keys: Unpack[Keys],
) -> Run:
    """Tracks a recording, as the program's `track` does: a folder of png, jpg, bmp or tif pictures, or a multi-page TIFF.

    sensor: what a pixel is; without it mm_per_px is the scale, and without that lengths are in pixels.
    config, keys: the configuration, `seamtrack.Config`; keys come first.
    truth: a CSV with the columns frame and u_px or v_px, to report errors against.
    frames: a part "A..B" of the recording, from frame A up to but without B; either may be left out.
    origin: where x = 0 lies: at the first tracked frame, in the picture's centre, or at a pixel along the stripe.
    max_unavailable: the verdict is "bad" when the seam is unavailable on more than this part of the frames [%].
    tolerance_mm: half the width of the band that the path is to stay in [mm].

    Raises OSError when the recording cannot be opened, ValueError when it or a setting is wrong; in the program's words. A frame that
    cannot be read does not end a run: its status is "unreadable". Videos and MCAP logs need the program. Runs without the GIL.
    """
    native = track_recording(
        input,
        sensor=sensor,
        config=config,
        truth=truth,
        frames=frames,
        origin=str(origin),
        max_unavailable=max_unavailable,
        tolerance_mm=tolerance_mm,
        **keys,
    )
    return Run(native)


class Run:
    """What tracking a recording gave; it can be pickled.

    columns: the columns of path.csv as arrays of shape (frames,), number for number; NaN where there is no value.
    summary: the content of summary.json.
    verdict: "good", "check" or "bad"; sentence, doubts and facts say why.
    notes: what there is to say of the recording, and of frames that could not be read.
    """

    columns: dict[str, NDArray[Any]]
    summary: dict[str, Any]
    verdict: str
    sentence: str
    doubts: list[str]
    facts: list[str]
    notes: list[str]

    def __init__(self, native: Recording) -> None:
        columns = native.columns()
        self.columns = {name: _array(name, values) for name, values in columns.items()}
        self.summary = native.summary
        self.verdict, self.sentence, self.doubts, self.facts = native.verdict
        self.notes = native.notes
        self._native: Recording | None = native
        self._csv: bytes | None = None

    def __len__(self) -> int:
        return len(self.columns["frame"])

    def __getitem__(self, column: str) -> NDArray[Any]:
        """A column of path.csv."""
        return self.columns[column]

    @property
    def unit(self) -> Literal["mm", "px"]:
        """The unit of positions along the stripe."""
        calibration = self.summary["calibration"]
        return "mm" if "mm_per_px" in calibration or "file" in calibration else "px"

    @property
    def joint(self) -> dict[str, Any]:
        """The kind of joint, the frame and the reason of the decision, and joints found later."""
        joint: dict[str, Any] = self.summary["joint"]
        return joint

    @property
    def smoothed(self) -> dict[str, NDArray[np.float64]]:
        """The smoothed path: u_px, v_px, std_px (along the stripe), x_mm, x_std_mm; arrays of shape (frames,), NaN without a value."""
        names = {
            "u_px": "smooth_u_px",
            "v_px": "smooth_v_px",
            "std_px": "smooth_along_std_px",
            "x_mm": "smooth_x_mm",
            "x_std_mm": "smooth_x_std_mm",
        }
        return {name: self.columns[column] for name, column in names.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The table of path.csv, one row a frame. Needs pandas."""
        import pandas

        table = pandas.DataFrame(self.columns)
        for name in FLAGS:
            table[name] = table[name].astype("boolean")
        return table

    def to_arrow(self) -> pyarrow.Table:
        """The table of path.csv, one row a frame; null where there is no value. Needs pyarrow."""
        import pyarrow

        def column(name: str, values: NDArray[Any]) -> pyarrow.Array:
            if name in FLAGS:
                missing = np.isnan(values)
                return pyarrow.array(np.where(missing, False, values == 1.0), mask=missing)
            return pyarrow.array(values, from_pandas=True)

        return pyarrow.table({name: column(name, values) for name, values in self.columns.items()})

    def to_csv(self) -> bytes:
        """path.csv, byte for byte as the program writes it."""
        if self._csv is None:
            assert self._native is not None
            self._csv = self._native.csv()
        return self._csv

    def write_csv(self, path: Path) -> None:
        """Writes path.csv."""
        with open(path, "wb") as file:
            file.write(self.to_csv())

    def plot(self, ax: Axes | None = None, *, truth: Mapping[str, Any] | None = None) -> Axes:
        """Draws the path along the stripe over the frames, with ± 2 σ. Needs matplotlib.

        truth: true columns or rows, as `synth.render` gives them (`truth._asdict()`), drawn beside it.
        """
        return _picture.plot(self, ax, truth)

    def along(self, estimate: Literal["filtered", "smoothed"]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position along the stripe and its σ, in `unit`; arrays of shape (frames,)."""
        prefix = "smooth_" if estimate == "smoothed" else ""
        if self.unit == "mm":
            return self.columns[prefix + "x_mm"], self.columns[prefix + "x_std_mm"]
        coordinate = "u_px" if self.summary["calibration"]["stripe"] == "horizontal" else "v_px"
        return self.columns[prefix + coordinate], self.columns[prefix + "along_std_px"]

    def __repr__(self) -> str:
        return f"<Run {self.verdict.upper()}: {self.sentence} Joint: {self.joint['kind']}.>"

    def _repr_html_(self) -> str:
        return _picture.html(self)

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        state["_csv"], state["_native"] = self.to_csv(), None
        return state


def _array(name: str, values: Any) -> NDArray[Any]:
    return np.asarray(values, dtype=np.str_ if name in TEXTS else None)
