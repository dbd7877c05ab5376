"""A run as a picture: drawn without any library for notebooks, and by matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._run import Run

Floats = NDArray[np.float64]

# The colours of the program's own page.
FILTERED, SMOOTHED, TRUTH = "#1f6fd6", "#d9480f", "#2b8a3e"
STATUS = {"seeking": "#ced4da", "tracked": "#8ce99a", "coasting": "#ffd43b", "lost": "#ff8787", "unreadable": "#495057"}
VERDICT = {"good": "#2b8a3e", "check": "#e67700", "bad": "#c92a2a"}

# Size of the picture and of the chart in it [px].
WIDTH, HEIGHT, LEFT, TOP, RIBBON = 720, 260, 56, 12, 10
CHART_WIDTH, CHART_HEIGHT = WIDTH - LEFT - 12, HEIGHT - TOP - RIBBON - 34
# More points than this are not drawn: the picture has fewer columns.
MOST_POINTS = 1440


def label(run: Run) -> str:
    return "x along the stripe [mm]" if run.unit == "mm" else "seam along the stripe [px]"


def plot(run: Run, ax: Axes | None, truth: Mapping[str, Any] | None) -> Axes:
    import matplotlib.pyplot as plt

    if ax is None:
        _, ax = plt.subplots(figsize=(8, 3.2), layout="constrained")
    frame = run["frame"]
    (x, std), (smooth, _) = run.along("filtered"), run.along("smoothed")
    ax.fill_between(frame, x - 2 * std, x + 2 * std, color=FILTERED, alpha=0.2, linewidth=0, label="± 2 σ")
    ax.plot(frame, x, color=FILTERED, linewidth=1.2, label="filtered")
    ax.plot(frame, smooth, color=SMOOTHED, linewidth=1.2, linestyle="--", label="smoothed")
    if truth is not None:
        ax.plot(frame, _true_position(run, truth), color=TRUTH, linewidth=1.0, label="truth")
    ax.set_xlabel("frame")
    ax.set_ylabel(label(run))
    ax.set_title(f"{run.verdict.upper()}: {run.sentence}", fontsize=9, loc="left")
    ax.legend(fontsize=8)
    return ax


def _true_position(run: Run, truth: Mapping[str, Any]) -> Floats:
    calibration = run.summary["calibration"]
    along = "u_px" if calibration["stripe"] == "horizontal" else "v_px"
    position = np.asarray(truth[along], dtype=np.float64)
    if run.unit == "px":
        return position
    if "mm_per_px" not in calibration:
        raise ValueError("a truth in pixels has no place in the laser's plane: convert it with Sensor.to_plane")
    return np.asarray(calibration["mm_per_px"] * (position - calibration["origin_px"]), dtype=np.float64)


def html(run: Run) -> str:
    """Verdict, chart and doubts; no script, nothing from outside."""
    head = (
        f'<span style="background:{VERDICT[run.verdict]};color:#fff;border-radius:4px;padding:1px 7px">'
        f"{run.verdict.upper()}</span> {escape(run.sentence)} Joint: {escape(run.joint['kind'])}."
    )
    doubts = "".join(f"<li>{escape(doubt)}</li>" for doubt in run.doubts)
    listed = f'<ul style="margin:4px 0">{doubts}</ul>' if doubts else ""
    return f'<div style="font:13px sans-serif">{head}{listed}{svg(run)}</div>'


def svg(run: Run) -> str:
    """The path along the stripe over the frames, and a ribbon of the statuses."""
    (x, std), (smooth, _) = run.along("filtered"), run.along("smoothed")
    values = np.concatenate([x, smooth])
    values = values[np.isfinite(values)]
    count = max(len(run) - 1, 1)
    parts = list(_ribbon(run))
    if values.size:
        low, high = float(values.min()), float(values.max())
        middle, half = 0.5 * (low + high), max(0.55 * (high - low), 1e-3)
        keep = np.unique(np.linspace(0, len(run) - 1, min(len(run), MOST_POINTS)).astype(int))
        across = LEFT + CHART_WIDTH * keep / count

        def down(position: Floats) -> Floats:
            share = np.clip((position[keep] - (middle - half)) / (2 * half), -0.2, 1.2)
            return np.asarray(TOP + CHART_HEIGHT * (1.0 - share))

        for tick in np.linspace(middle - half, middle + half, 5):
            y = TOP + CHART_HEIGHT * (1.0 - (tick - middle + half) / (2 * half))
            parts.append(f'<line x1="{LEFT}" x2="{LEFT + CHART_WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="#e9ecef"/>')
            parts.append(f'<text x="{LEFT - 4}" y="{y + 4:.1f}" text-anchor="end">{tick:.2f}</text>')
        for band in _pieces(across, down(x - 2 * std), down(x + 2 * std)):
            outline = [*band[:, [0, 1]], *band[::-1, [0, 2]]]
            parts.append(f'<polygon points="{_points(outline)}" fill="{FILTERED}" fill-opacity=".2"/>')
        for position, colour, dashes in ((x, FILTERED, ""), (smooth, SMOOTHED, ' stroke-dasharray="5 3"')):
            for piece in _pieces(across, down(position)):
                style = f'fill="none" stroke="{colour}" stroke-width="1.3"{dashes}'
                parts.append(f'<polyline points="{_points(piece)}" {style}/>')
    foot = f"frame 0 to {len(run) - 1}; {label(run)}: filtered ± 2 σ, smoothed dashed; below, the status"
    parts.append(f'<text x="{LEFT}" y="{HEIGHT - 6}">{escape(foot)}</text>')
    size = f'width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"'
    style = 'style="max-width:100%;background:#fff" font-family="sans-serif" font-size="11"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {style}>{"".join(parts)}</svg>'


def _ribbon(run: Run) -> Iterable[str]:
    status = run["status"]
    starts = [0, *(np.flatnonzero(status[1:] != status[:-1]) + 1).tolist(), len(status)]
    width = CHART_WIDTH / max(len(status), 1)
    y = TOP + CHART_HEIGHT + 6
    for first, end in zip(starts, starts[1:], strict=False):
        x, name = LEFT + width * first, str(status[first])
        box = f'x="{x:.1f}" y="{y}" width="{width * (end - first):.1f}" height="{RIBBON}"'
        yield f'<rect {box} fill="{STATUS[name]}"><title>{name}, frame {first} to {end - 1}</title></rect>'


def _pieces(*columns: Floats) -> Iterable[Floats]:
    """The rows of the columns, cut where one of them has no value."""
    table = np.column_stack(columns)
    known = np.isfinite(table).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        yield table[first:end]


def _points(rows: Iterable[Any]) -> str:
    return " ".join(f"{row[0]:.1f},{row[1]:.1f}" for row in rows)
