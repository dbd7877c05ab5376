"""A Slurm array: `sbatch` does the rest."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path

from .files import write_whole
from .plans import read_plan

#: Slurm refuses larger arrays unless it is told otherwise (MaxArraySize 1001).
MOST_TASKS = 1000


def write_sbatch(
    out: str | os.PathLike[str],
    *,
    tasks: int | None = None,
    at_once: int | None = None,
    options: list[str] | None = None,
    python: str = sys.executable,
) -> Path:
    """Writes `fleet.sbatch` into a data set that is planned: each task of the array tracks every so-many-th shard.

    tasks: tasks of the array, at most 1000 as Slurm is delivered. at_once: how many of them run at a time. options: more lines
    for `#SBATCH`, such as "--partition=weld". python: the interpreter on the nodes. A task that is requeued goes on where it was.
    """
    folder = Path(out).resolve()
    shards = read_plan(folder).shards
    tasks = min(tasks or MOST_TASKS, shards)
    limit = f"%{at_once}" if at_once else ""
    settings = [
        "--job-name=seamtrack",
        f"--array=0-{tasks - 1}{limit}",
        "--cpus-per-task=1",
        "--requeue",
        f"--output={folder}/logs/%a.txt",
        "--open-mode=append",
        *(options or []),
    ]
    (folder / "logs").mkdir(exist_ok=True)
    lines = ["#!/bin/bash", *(f"#SBATCH {setting}" for setting in settings)]
    command = f"{shlex.quote(python)} -m seamtrack.fleet shard {shlex.quote(str(folder))}"
    lines.append(f'exec {command} "$SLURM_ARRAY_TASK_ID" --every {tasks}')
    target = folder / "fleet.sbatch"
    write_whole(target, lambda part: part.write_text("\n".join(lines) + "\n", encoding="utf-8"))
    return target
