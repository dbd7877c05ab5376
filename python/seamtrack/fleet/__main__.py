"""`seamtrack-fleet`, or `python -m seamtrack.fleet`: run, plan, shard, check, page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .._native import Config, Sensor
from .checks import check
from .engines import run
from .page import write_page
from .plans import SHARD_SIZE, PlanError, plan, read_plan
from .shards import shard
from .slurm import write_sbatch


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs a command; exits with 0 when all is done, 1 on an error, 3 when a data set is not complete."""
    given = _parser().parse_args(arguments)
    try:
        sys.exit(given.command(given))
    except (PlanError, OSError, ValueError) as error:
        sys.exit(f"error: {error}")


def _run(given: argparse.Namespace) -> int:
    def tell(number: int, error: BaseException | None) -> None:
        if error is not None:
            print(f"shard {number} failed: {error}", file=sys.stderr, flush=True)
        elif not given.quiet:
            print(f"shard {number} is done", file=sys.stderr, flush=True)

    report = run(
        given.manifest,
        given.output,
        engine=given.engine,
        jobs=given.jobs,
        address=given.address,
        tell=tell,
        shard_size=given.shard_size,
        **_settings(given),
    )
    print(report)
    return 0 if report.is_complete else 3


def _plan(given: argparse.Namespace) -> int:
    made = plan(given.manifest, given.output, shard_size=given.shard_size, **_settings(given))
    print(f"{made.recordings} recordings in {made.shards} shards")
    if given.sbatch:
        print(write_sbatch(given.output, tasks=given.tasks, at_once=given.at_once, options=given.slurm_option))
    return 0


def _shard(given: argparse.Namespace) -> int:
    numbers = range(given.number, read_plan(given.output).shards, given.every) if given.every else [given.number]
    for number in numbers:
        print(f"shard {number}: {shard(given.output, number)} recordings", flush=True)
    return 0


def _check(given: argparse.Namespace) -> int:
    report = check(given.output)
    print(report)
    return 0 if report.is_complete else 3


def _page(given: argparse.Namespace) -> int:
    print(write_page(given.output))
    return 0


def _settings(given: argparse.Namespace) -> dict[str, Any]:
    config = Config() if given.config is None else Config.read(given.config)
    if given.mm_per_px is not None:
        config = config.replace(mm_per_px=given.mm_per_px)
    sensor = None if given.calibration is None else Sensor.read(given.calibration)
    return {
        "config": config,
        "sensor": sensor,
        "origin": given.origin,
        "max_unavailable": given.max_unavailable,
        "tolerance_mm": given.tolerance,
    }


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("seamtrack-fleet", description="Tracks the recordings of a manifest into two Parquet tables")
    commands = parser.add_subparsers(required=True)

    settings = argparse.ArgumentParser(add_help=False)
    settings.add_argument("manifest", type=Path, help="a CSV with the columns input[,truth]")
    settings.add_argument("-o", "--output", type=Path, required=True, help="the folder of the data set")
    settings.add_argument("--shard-size", type=int, default=SHARD_SIZE, help="recordings of a shard [%(default)s]")
    settings.add_argument("--config", type=Path, help="configuration (TOML), as of `seamtrack track`")
    scale = settings.add_mutually_exclusive_group()
    scale.add_argument("--mm-per-px", type=float, help="one scale along the stripe [mm/px]")
    scale.add_argument("--calibration", type=Path, help="camera and laser plane, or a scale (TOML)")
    settings.add_argument("--origin", default="first", help="where x = 0 lies: first, centre or a pixel [%(default)s]")
    settings.add_argument("--max-unavailable", type=float, default=5.0, help="BAD beyond this part of the frames [%%]")
    settings.add_argument("--tolerance", type=float, help="half the width of the band the path is to stay in [mm]")

    command = commands.add_parser("run", parents=[settings], help="plan, track what is missing, check")
    command.add_argument("--engine", choices=["local", "ray"], default="local")
    command.add_argument("--jobs", type=int, help="threads of the engine local [as many as processors]")
    command.add_argument("--address", help="a running Ray cluster: auto, or ray://host:10001")
    command.add_argument("-q", "--quiet", action="store_true", help="tell of failures only")
    command.set_defaults(command=_run)

    command = commands.add_parser("plan", parents=[settings], help="cut the manifest into shards")
    command.add_argument("--sbatch", action="store_true", help="also write fleet.sbatch, an array for Slurm")
    command.add_argument("--tasks", type=int, help="tasks of that array [as many as shards, at most 1000]")
    command.add_argument("--at-once", type=int, help="tasks that run at a time [as Slurm likes]")
    command.add_argument("--slurm-option", action="append", help="one more line for #SBATCH, as --slurm-option=--mem=2G")
    command.set_defaults(command=_plan)

    command = commands.add_parser("shard", help="track one shard")
    command.add_argument("output", type=Path)
    command.add_argument("number", type=int)
    command.add_argument("--every", type=int, metavar="N", help="then every N-th shard behind it")
    command.set_defaults(command=_shard)

    for name, do, text in (
        ("check", _check, "whether each recording is there exactly once"),
        ("page", _page, "write index.html"),
    ):
        command = commands.add_parser(name, help=text)
        command.add_argument("output", type=Path)
        command.set_defaults(command=do)
    return parser


if __name__ == "__main__":
    main()
