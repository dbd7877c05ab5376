"""`index.html`: verdicts, the distribution of errors, and the worst recordings first."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from .._picture import VERDICT
from .files import write_whole
from .plans import Plan, read_plan

#: Recordings that are listed. Chosen: more are found by a query.
WORST = 200
BARS, BAR_WIDTH, CHART_HEIGHT = 40, 14, 120
COLUMNS = [
    "recording",
    "shard",
    "failure",
    "verdict",
    "sentence",
    "doubts",
    "joint",
    "unit",
    "frames_total",
    "frames_tracked",
    "filtered_mae",
    "filtered_max",
    "smoothed_mae",
    "smoothed_max",
    "track_ms_p50",
]
#: The worst first.
RANK = {"failed": 0, "bad": 1, "check": 2, "good": 3}
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; color: #212529 }
table { border-collapse: collapse; width: 100%; font-size: 13px } th, td { text-align: left; padding: 3px 8px; vertical-align: top }
tr { border-bottom: 1px solid #e9ecef } td.number { text-align: right; font-variant-numeric: tabular-nums }
.badge { color: #fff; border-radius: 4px; padding: 1px 7px; font-size: 12px } .charts { display: flex; flex-wrap: wrap; gap: 2rem }
figure { margin: 0 } figcaption { font-size: 13px } small { color: #495057 }
"""
COLOURS = {"failed": "#495057", **VERDICT}


def write_page(out: str | os.PathLike[str]) -> Path:
    """Writes `index.html` of a data set from its table of recordings, as far as that is there."""
    folder = Path(out)
    plan = read_plan(folder)
    target = folder / "index.html"
    text = "".join(_page(plan, _rows(folder), folder.resolve().name))
    write_whole(target, lambda part: part.write_text(text, encoding="utf-8"))
    return target


def _rows(folder: Path) -> pa.Table:
    files = sorted((folder / "recordings").glob("*.parquet"))
    tables = [pq.read_table(file, columns=COLUMNS) for file in files]
    return pa.concat_tables(tables) if tables else pa.table({name: [] for name in COLUMNS})


def _page(plan: Plan, rows: pa.Table, name: str) -> Iterator[str]:
    verdicts = [verdict or "failed" for verdict in rows["verdict"].to_pylist()]
    counts = Counter(verdicts)
    yield f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(name)}</title><style>{STYLE}</style>'
    yield f"<h1>{escape(name)}</h1><p>{rows.num_rows} of {plan.recordings} recordings, "
    yield f"{_total(rows, 'frames_total')} frames, tracked on {_total(rows, 'frames_tracked')}. "
    yield f"<small>seamtrack {escape(plan.program)}</small></p><p>"
    for verdict in RANK:
        yield f"{_badge(verdict)} {counts[verdict]} &nbsp; "
    yield "</p>"
    yield '<div class="charts">'
    for unit in ("mm", "px"):
        of_unit = rows.filter(pc.equal(rows["unit"], unit)) if rows.num_rows else rows
        for column, title in (("filtered_mae", "mean error, filtered"), ("smoothed_mae", "mean error, smoothed"), ("filtered_max", "largest error, filtered")):
            yield from _histogram(_values(of_unit, column), f"{title} [{unit}]")
    yield from _histogram(_values(rows, "track_ms_p50"), "a step of the tracker, median of a recording [ms]")
    yield "</div>"
    yield from _worst(rows, verdicts)
    yield "</html>\n"


def _total(rows: pa.Table, column: str) -> int:
    return int(sum(value or 0 for value in rows[column].to_pylist()))


def _values(rows: pa.Table, column: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    values = np.array(rows[column].to_pylist(), dtype=np.float64)
    return values[np.isfinite(values)]


def _badge(verdict: str) -> str:
    return f'<span class="badge" style="background:{COLOURS[verdict]}">{verdict.upper()}</span>'


def _histogram(values: np.ndarray[Any, np.dtype[np.float64]], title: str) -> Iterator[str]:
    """Bars of equal width up to the 99 % rank; what lies beyond is in the last one."""
    if not values.size:
        return
    end = float(np.quantile(values, 0.99)) or 1.0
    counts, _ = np.histogram(np.minimum(values, end), bins=BARS, range=(0.0, end))
    width, most = BARS * BAR_WIDTH, int(counts.max())
    quantiles = ", ".join(f"{100 * q:.0f} %: {np.quantile(values, q):.3g}" for q in (0.5, 0.95, 0.99, 1.0))
    yield f'<figure><svg width="{width}" height="{CHART_HEIGHT + 18}" viewBox="0 0 {width} {CHART_HEIGHT + 18}">'
    for bar, count in enumerate(counts.tolist()):
        height = CHART_HEIGHT * count / most
        first, last = end * bar / BARS, end * (bar + 1) / BARS
        box = f'x="{bar * BAR_WIDTH}" y="{CHART_HEIGHT - height:.1f}" width="{BAR_WIDTH - 2}" height="{height:.1f}"'
        yield f'<rect {box} fill="#1f6fd6"><title>{first:.3g} to {last:.3g}: {count}</title></rect>'
    for share in (0.0, 0.5, 1.0):
        anchor = {0.0: "start", 1.0: "end"}.get(share, "middle")
        at = f'x="{share * width:.0f}" y="{CHART_HEIGHT + 14}" font-size="11"'
        yield f'<text {at} text-anchor="{anchor}">{end * share:.3g}</text>'
    yield f"</svg><figcaption>{escape(title)}; {quantiles}</figcaption></figure>"


def _worst(rows: pa.Table, verdicts: Sequence[str]) -> Iterator[str]:
    table: list[dict[str, Any]] = rows.to_pylist()
    order = sorted(range(len(table)), key=lambda i: (RANK[verdicts[i]], -(table[i]["filtered_max"] or 0.0), i))
    yield f"<h2>The worst first</h2><p><small>{min(WORST, len(order))} of {len(order)}; the table has them all.</small></p><table>"
    yield "<tr><th>verdict<th>recording<th>joint<th>frames<th>mean error<th>largest<th>why</tr>"
    for i in order[:WORST]:
        row = table[i]
        why = row["failure"] or " ".join(row["doubts"] or [row["sentence"] or ""])
        cells = [_badge(verdicts[i]), escape(row["recording"]), escape(row["joint"] or ""), _text(row["frames_total"])]
        for error in ("filtered_mae", "filtered_max"):
            cells.append("" if row[error] is None else f"{row[error]:.3f} {row['unit']}")
        numbers = {3, 4, 5}
        parts = (f'<td{" class=number" if k in numbers else ""}>{cell}' for k, cell in enumerate([*cells, escape(why)]))
        yield f"<tr>{''.join(parts)}</tr>"
    yield "</table>"


def _text(value: object) -> str:
    return "" if value is None else str(value)
