"""Thousands of recordings: a manifest becomes a data set of two Parquet tables, shard by shard.

>>> from seamtrack import fleet
>>> fleet.run("recordings.csv", "out", engine="local", mm_per_px=0.073)       # doctest: +SKIP

`plan` cuts the manifest into shards, `shard` tracks one of them, `check` says whether each recording is there exactly once with all of its
frames. An engine only has to call `shard` for every number, as often as it likes and wherever it likes: a shard that has its files is left
alone, and its files appear whole or not at all. Scheduling, retries and lost nodes are the engine's: threads here ("local"), Ray, a Slurm
array, or Dask by the same three calls.

A data set is a folder: `plan.json`, `manifest.parquet` (a row group a shard), `recordings/*.parquet` (a row a recording),
`frames/*.parquet` (the columns of path.csv, a row a frame), `index.html`.
"""

from __future__ import annotations

from .checks import Report, check
from .engines import run
from .page import write_page
from .plans import Plan, PlanError, plan, read_plan
from .shards import shard
from .slurm import write_sbatch

__all__ = ["Plan", "PlanError", "Report", "check", "plan", "read_plan", "run", "shard", "write_page", "write_sbatch"]
