"""Who calls `shard`: threads of this process, or Ray."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, Literal

from .checks import Report, check
from .page import write_page
from .plans import SHARD_SIZE, plan, read_plan, shards_done
from .shards import shard

#: Shards a processor that Ray is given beforehand. Chosen: enough that none waits, few enough for a driver of any fleet.
AHEAD = 4
#: How often Ray runs a shard again when its worker or node is gone, or a store does not answer. Chosen: nodes that are taken away go
#: more often than once, and a shard that kills its worker each time must end.
RETRIES = 10

#: Called after each shard with its number and, when it failed, the error.
Tell = Callable[[int, "BaseException | None"], None]


def run(
    manifest: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    engine: Literal["local", "ray"] = "local",
    jobs: int | None = None,
    address: str | None = None,
    tell: Tell | None = None,
    shard_size: int = SHARD_SIZE,
    **settings: Any,
) -> Report:
    """Plans, tracks all shards that have no files yet, writes `index.html`, and checks.

    engine: "local" tracks in `jobs` threads of this process (as many as processors where it is not given); "ray" in tasks of the running
    cluster at `address` ("auto", "ray://host:10001"), or of one started here. tell: called after each shard.
    settings: those of `plan`: sensor, config, mm_per_px and so on.

    A shard that fails does not end the others; the report says what is missing, and the same call goes on there.
    """
    folder = Path(out)
    made = plan(manifest, folder, shard_size=shard_size, **settings)
    done = shards_done(folder)
    todo = [number for number in range(made.shards) if number not in done]
    tell = tell or (lambda number, error: None)
    if engine == "local":
        run_local(folder, todo, jobs or os.cpu_count() or 1, tell)
    elif engine == "ray":
        run_ray(folder, todo, address, tell)
    else:
        raise ValueError(f"there is no engine {engine!r}: local or ray; for Slurm write an sbatch file with `write_sbatch`")
    write_page(folder)
    return check(folder)


def run_local(out: Path, todo: Iterable[int], jobs: int, tell: Tell) -> None:
    """Tracks shards in threads: tracking runs without the GIL."""
    numbers = iter(todo)
    running: dict[Future[int], int] = {}
    with ThreadPoolExecutor(jobs) as pool:
        while True:
            while len(running) < jobs and (number := next(numbers, None)) is not None:
                running[pool.submit(shard, out, number)] = number
            if not running:
                break
            ready, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in ready:
                tell(running.pop(future), future.exception())


def run_ray(out: Path, todo: Iterable[int], address: str | None, tell: Tell) -> None:
    """Tracks shards in tasks of Ray; a task on a node that is lost is run again elsewhere, by Ray."""
    import ray

    if not ray.is_initialized():
        alone: dict[str, Any] = {} if address else {"include_dashboard": False}
        ray.init(address=address, log_to_driver=False, **alone)
    task = ray.remote(num_cpus=1, max_retries=RETRIES, retry_exceptions=[OSError])(shard)
    numbers, place = iter(todo), str(out.resolve())
    running: dict[Any, int] = {}
    while True:
        limit = AHEAD * max(1, int(ray.cluster_resources().get("CPU", 1)))
        while len(running) < limit and (number := next(numbers, None)) is not None:
            running[task.remote(place, number)] = number
        if not running:
            break
        ready, _ = ray.wait(list(running), num_returns=1)
        for reference in ready:
            number = running.pop(reference)
            try:
                ray.get(reference)
                tell(number, None)
            except ray.exceptions.RayError as error:
                tell(number, error)


def missing(out: str | os.PathLike[str]) -> list[int]:
    """The numbers of the shards that have no files yet."""
    folder = Path(out)
    done = shards_done(folder)
    return [number for number in range(read_plan(folder).shards) if number not in done]
