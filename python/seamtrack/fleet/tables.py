"""The columns of the two tables."""

from __future__ import annotations

import json
from typing import Any

import pyarrow as pa

from .._run import FLAGS, Run

#: Counts of frames in summary.json.
COUNTS = (
    "total",
    "seeking",
    "tracked",
    "coasting",
    "lost",
    "unreadable",
    "repeated",
    "saturated",
    "frozen",
    "bad_stamps",
)
#: Errors against a truth, for each estimate: mean, maximum and bias in the unit of the run, frames that are wrong.
ERRORS = ("mae", "max", "rmse", "bias", "coverage_2sigma", "wrong_frames")
ESTIMATES = ("filtered", "smoothed")

RECORDINGS = pa.schema(
    [
        ("recording", pa.string()),
        ("shard", pa.int32()),
        ("failure", pa.string()),
        ("verdict", pa.string()),
        ("sentence", pa.string()),
        ("doubts", pa.list_(pa.string())),
        ("joint", pa.string()),
        ("joint_frame", pa.int32()),
        ("unit", pa.string()),
        ("width_px", pa.int32()),
        ("height_px", pa.int32()),
        *((f"frames_{name}", pa.int32()) for name in COUNTS),
        *((f"{estimate}_{name}", pa.float64()) for estimate in ESTIMATES for name in ERRORS),
        ("decode_ms_p50", pa.float64()),
        ("track_ms_p50", pa.float64()),
        ("track_ms_p99", pa.float64()),
        ("seconds", pa.float64()),
        ("summary", pa.string()),
    ]
)


def recording_row(recording: str, number: int, run: Run, seconds: float) -> dict[str, Any]:
    """The row of a recording that was tracked."""
    summary = run.summary
    timing, errors = summary["timing"], summary.get("errors") or {}
    return {
        "recording": recording,
        "shard": number,
        "failure": None,
        "verdict": run.verdict,
        "sentence": run.sentence,
        "doubts": run.doubts,
        "joint": run.joint["kind"],
        "joint_frame": run.joint["decided_at_frame"],
        "unit": run.unit,
        "width_px": summary["input"]["width_px"],
        "height_px": summary["input"]["height_px"],
        **{f"frames_{name}": summary["frames"][name] for name in COUNTS},
        **{f"{of}_{name}": _error(errors.get(of), name) for of in ESTIMATES for name in ERRORS},
        "decode_ms_p50": timing["decode_ms"]["p50"],
        "track_ms_p50": timing["track_ms"]["p50"],
        "track_ms_p99": timing["track_ms"]["p99"],
        "seconds": seconds,
        "summary": json.dumps(summary, ensure_ascii=False),
    }


def _error(errors: dict[str, Any] | None, name: str) -> float | None:
    if errors is None:
        return None
    # Lengths carry their unit in summary.json.
    value = next((errors[key] for key in (name, f"{name}_mm", f"{name}_px") if key in errors), None)
    return None if value is None else float(value)


def failure_row(recording: str, number: int, failure: str, seconds: float) -> dict[str, Any]:
    """The row of a recording that cannot be tracked."""
    return {"recording": recording, "shard": number, "failure": failure, "seconds": seconds}


def frames_table(recording: str, run: Run) -> pa.Table:
    """The table of path.csv, with the recording's name in front."""
    table = run.to_arrow()
    table = table.set_column(table.schema.get_field_index("frame"), "frame", table["frame"].cast(pa.int32()))
    return table.add_column(0, "recording", pa.repeat(pa.scalar(recording), table.num_rows))


def no_frames() -> pa.Table:
    """A table of no frame."""
    from .._native import value_columns

    text = [("recording", pa.string()), ("frame", pa.int32()), ("file", pa.string())]
    times = [("time_s", pa.float64()), ("status", pa.string())]
    values = [(name, pa.bool_() if name in FLAGS else pa.float64()) for name in value_columns()]
    return pa.schema([*text, *times, *values]).empty_table()
