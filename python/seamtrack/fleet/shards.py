"""One shard: its recordings are tracked into two files."""

from __future__ import annotations

import os
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from .._native import Config, Sensor
from .._run import Run, track
from .files import write_whole
from .plans import Plan, PlanError, listed, program, read_plan
from .sources import Sources
from .tables import RECORDINGS, failure_row, frames_table, no_frames, recording_row


def shard(out: str | os.PathLike[str], number: int) -> int:
    """Tracks the shard `number` of the data set in `out`; gives how many recordings it tracked: none when it has its files already.

    A recording that is missing or cannot be tracked is a row with its `failure`. What may be better at another try (a store that does not
    answer, a full disk) is raised, for the engine to try again.

    Raises PlanError when there is no such shard, or the plan is of another program.
    """
    folder = Path(out)
    plan = read_plan(folder)
    if plan.program != program():
        raise PlanError(f"{folder} was begun with another program, {plan.program}; this one is {program()}")
    if not 0 <= number < plan.shards:
        raise PlanError(f"{folder} has {plan.shards} shards, numbered from 0: there is none of number {number}")
    target = folder / "recordings" / name_of(number)
    if target.exists():
        return 0
    rows: list[dict[str, Any]] = []
    tables = [no_frames()]
    with Sources() as sources:
        for listed_row in listed(folder, number):
            row, run = _recording(plan, number, listed_row, sources)
            rows.append(row)
            if run is not None:
                tables.append(frames_table(listed_row["recording"], run))
    for part in ("frames", "recordings"):
        (folder / part).mkdir(exist_ok=True)
    frames = pa.concat_tables(tables)
    write_whole(folder / "frames" / name_of(number), lambda part: pq.write_table(frames, part, compression="zstd"))
    recordings = pa.Table.from_pylist(rows, RECORDINGS)
    # Last: it says that the shard is done.
    write_whole(target, lambda part: pq.write_table(recordings, part, compression="zstd"))
    return len(rows)


def name_of(number: int) -> str:
    """The name of a shard's files."""
    return f"{number:06d}.parquet"


def _recording(
    plan: Plan, number: int, listed_row: dict[str, Any], sources: Sources
) -> tuple[dict[str, Any], Run | None]:
    began = time.perf_counter()
    recording = listed_row["recording"]
    with ExitStack() as stack:
        try:
            path = stack.enter_context(sources.local(listed_row["input"]))
            truth = stack.enter_context(sources.local(listed_row["truth"])) if listed_row["truth"] else None
        except (FileNotFoundError, ValueError) as error:
            return failure_row(recording, number, str(error), time.perf_counter() - began), None
        try:
            run = track(
                path,
                sensor=None if plan.sensor is None else Sensor(**plan.sensor),
                config=Config(**plan.config),
                truth=truth,
                **plan.options,
            )
        except (OSError, ValueError) as error:
            failure = str(error).replace(str(path), recording)
            return failure_row(recording, number, failure, time.perf_counter() - began), None
    # Not where it lay while it was tracked.
    run.summary["input"]["path"] = recording
    return recording_row(recording, number, run, time.perf_counter() - began), run
