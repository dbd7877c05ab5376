"""Whether each recording is there exactly once, with all of its frames."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from .files import PART
from .plans import Plan, listed, read_plan
from .shards import name_of

#: Problems that are told one by one; of more only the number. Chosen: a screen.
MOST_TOLD = 20


@dataclass(frozen=True)
class Report:
    """What a check found."""

    #: Recordings in the manifest, and those that have a row.
    listed: int
    recordings: int
    #: Of these, the ones that could not be tracked.
    failures: int
    #: Frames in the table of frames.
    frames: int
    #: Shards without files.
    missing_shards: int
    #: What is wrong, each in a line; the first ones of many.
    problems: tuple[str, ...]
    #: Files that a killed run left behind; they do no harm.
    leftovers: tuple[str, ...]

    @property
    def is_complete(self) -> bool:
        """Each recording is there exactly once with all of its frames."""
        return not self.missing_shards and not self.problems

    def __str__(self) -> str:
        lines = [
            f"{self.recordings} of {self.listed} recordings, {self.failures} of them failed, {self.frames} frames",
            *([f"{self.missing_shards} shards are not done: run the same command again"] if self.missing_shards else []),
            *self.problems,
            *(f"left behind by a run that was ended: {name}" for name in self.leftovers),
            "each recording exactly once, all of its frames there" if self.is_complete else "NOT COMPLETE",
        ]
        return "\n".join(lines)


def check(out: str | os.PathLike[str]) -> Report:
    """Reads all tables of a data set, a shard at a time.

    Raises PlanError when `out` is no data set.
    """
    folder = Path(out)
    plan = read_plan(folder)
    recordings = failures = frames = missing = 0
    problems: list[str] = []
    for number in range(plan.shards):
        target = folder / "recordings" / name_of(number)
        if not target.exists():
            missing += 1
            continue
        try:
            rows = pq.read_table(target, columns=["recording", "shard", "failure", "frames_total"])
            seen = pq.read_table(folder / "frames" / name_of(number), columns=["recording", "frame"])
        except (OSError, pa.ArrowInvalid) as error:
            problems.append(f"shard {number} cannot be read: {error}")
            continue
        recordings += rows.num_rows
        failures += rows.num_rows - rows["failure"].null_count
        frames += seen.num_rows
        problems.extend(_problems(folder, number, rows, seen))
    problems.extend(_strangers(folder, plan))
    told = problems[:MOST_TOLD] + ([f"and {len(problems) - MOST_TOLD} more"] if len(problems) > MOST_TOLD else [])
    leftovers = sorted(str(part.relative_to(folder)) for part in folder.rglob(f".*{PART}"))
    return Report(plan.recordings, recordings, failures, frames, missing, tuple(told), tuple(leftovers))


def _problems(folder: Path, number: int, rows: pa.Table, seen: pa.Table) -> Iterator[str]:
    expected = [row["recording"] for row in listed(folder, number)]
    # A manifest lists no recording twice: shards that hold their own, and no other, hold all of them once.
    if rows["recording"].to_pylist() != expected:
        yield f"shard {number} does not hold the recordings that the manifest lists for it, each once"
    grouped = seen.group_by("recording").aggregate([("frame", "count"), ("frame", "count_distinct"), ("frame", "max")])
    counts = {
        name: (count, distinct, last)
        for name, count, distinct, last in zip(
            *(grouped[column].to_pylist() for column in ("recording", "frame_count", "frame_count_distinct", "frame_max")),
            strict=True,
        )
    }
    for recording, failure, total in zip(
        *(rows[name].to_pylist() for name in ("recording", "failure", "frames_total")), strict=True
    ):
        count, distinct, last = counts.pop(recording, (0, 0, -1))
        if (count, distinct, last) != ((0, 0, -1) if failure is not None else (total, total, total - 1)):
            yield f"{recording}: {count} frames, {distinct} different ones, of {total or 0}"
    for recording in counts:
        yield f"frames of {recording}, which is not in shard {number}"
    shards = pc.unique(rows["shard"]).to_pylist()
    if shards != [number]:
        yield f"the file of shard {number} holds shards {shards}"


def _strangers(folder: Path, plan: Plan) -> Iterator[str]:
    """Tables that belong to no shard; frames without their recordings belong to a shard that is not done."""
    for part in ("recordings", "frames"):
        for file in sorted((folder / part).glob("*.parquet")):
            if not (file.stem.isdigit() and int(file.stem) < plan.shards and file.name == name_of(int(file.stem))):
                yield f"{part}/{file.name} is no shard of this data set: take it away"
