"""What is to be done: the manifest, cut into shards, with all that decides on the results."""

from __future__ import annotations

import csv
import dataclasses
import functools
import hashlib
import io
import json
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.parquet as pq

from .. import _native
from .._native import Config, Sensor
from .files import write_whole

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .._keys import Keys

#: Version of `plan.json` and of the tables.
SCHEMA_VERSION = 1
#: Recordings of a shard where it is not given: minutes of work at some seconds a recording. Chosen.
SHARD_SIZE = 64

PLAN, MANIFEST = "plan.json", "manifest.parquet"


class PlanError(ValueError):
    """A plan that cannot be made, or does not fit what was begun."""


@dataclass(frozen=True)
class Plan:
    """What decides on a data set; written into `plan.json` and never changed."""

    #: SHA-256 of the manifest, and the number of recordings that it lists.
    manifest: str
    recordings: int
    #: Recordings of a shard.
    shard_size: int
    #: The configuration's keys that are not as in the default one.
    config: dict[str, Any]
    #: The sensor: the keywords of `seamtrack.Sensor`; none where the configuration says it.
    sensor: dict[str, Any] | None
    #: How the path is measured and judged: origin, max_unavailable [%], tolerance_mm.
    options: dict[str, Any]
    #: Version and check sum of the program.
    program: str
    schema_version: int = SCHEMA_VERSION

    @property
    def shards(self) -> int:
        """How many shards there are."""
        return -(-self.recordings // self.shard_size)


@functools.cache
def program() -> str:
    """Version of seamtrack, and the first digits of the SHA-256 of its native library."""
    library = getattr(_native, "__file__", "")
    return f"{_native.__version__}+{hashlib.sha256(Path(library).read_bytes()).hexdigest()[:12]}"


def plan(
    manifest: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    shard_size: int = SHARD_SIZE,
    sensor: Sensor | None = None,
    config: Config | None = None,
    origin: str = "first",
    max_unavailable: float = 5.0,
    tolerance_mm: float | None = None,
    **keys: Unpack[Keys],
) -> Plan:
    """Writes the plan of a data set into the folder `out`, or finds that it is the one which was begun there.

    manifest: a CSV with the columns input[,truth], with commas or semicolons. An input is a path (from the manifest's folder), a URL
    that fsspec knows (s3://bucket/folder), or a part of an archive (recordings.tar::monday/17, also behind a URL).
    shard_size: recordings of a shard. The rest is as for `seamtrack.track`.

    Raises PlanError when the manifest lists a recording twice or none at all, or when `out` was begun with another manifest,
    configuration, sensor, shard size or program: it names them.
    """
    source, folder = Path(manifest), Path(out)
    content = source.read_bytes()
    if shard_size < 1:
        raise PlanError("shard_size is at least 1")
    config = (config or Config()).replace(**keys)
    made = Plan(
        manifest=hashlib.sha256(content).hexdigest(),
        recordings=0,
        shard_size=shard_size,
        config=config.__getnewargs_ex__()[1],
        sensor=_keywords(sensor),
        options={"origin": str(origin), "max_unavailable": max_unavailable, "tolerance_mm": tolerance_mm},
        program=program(),
    )
    if (folder / PLAN).exists():
        begun = read_plan(folder)
        made = dataclasses.replace(made, recordings=begun.recordings)
        _expect_same(begun, made, folder)
        return begun
    table = _read_manifest(content.decode("utf-8-sig"), source)
    made = dataclasses.replace(made, recordings=table.num_rows)
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.glob("*/*.parquet")):
        raise PlanError(f"{folder} holds tables but no {PLAN}: choose another folder")
    write_whole(folder / MANIFEST, lambda part: pq.write_table(table, part, row_group_size=shard_size, compression="zstd"))
    text = json.dumps(dataclasses.asdict(made), indent=2) + "\n"
    # Last: it says that the plan is there.
    write_whole(folder / PLAN, lambda part: part.write_text(text, encoding="utf-8"))
    return made


def read_plan(out: str | os.PathLike[str]) -> Plan:
    """The plan of a data set. Raises PlanError when there is none, or it is of another version."""
    file = Path(out) / PLAN
    try:
        content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise PlanError(f"{file} is missing: make it with `seamtrack-fleet plan`") from None
    if content.get("schema_version") != SCHEMA_VERSION:
        raise PlanError(f"{file} has schema_version {content.get('schema_version')}, this program reads {SCHEMA_VERSION}")
    return Plan(**content)


def listed(out: Path, number: int) -> list[dict[str, Any]]:
    """The recordings of a shard: recording, input, truth."""
    rows: list[dict[str, Any]] = pq.ParquetFile(out / MANIFEST).read_row_group(number).to_pylist()
    return rows


def shards_done(out: Path) -> set[int]:
    """The numbers of the shards that have their files."""
    return {int(file.stem) for file in (out / "recordings").glob("*.parquet") if file.stem.isdigit()}


def _keywords(sensor: Sensor | None) -> dict[str, Any] | None:
    if sensor is None:
        return None
    (mm_per_px,), keywords = sensor.__getnewargs_ex__()
    return {"mm_per_px": mm_per_px, **keywords}


def _expect_same(begun: Plan, now: Plan, folder: Path) -> None:
    before, after = _by_name(begun), _by_name(now)
    differing = [name for name, value in after.items() if value != before.get(name)]
    if differing:
        names = " and ".join(differing)
        raise PlanError(f"{folder} was begun with another {names}: choose another folder, or go back to what it was begun with")


def _by_name(plan: Plan) -> dict[str, Any]:
    """All that must be the same, by what a user calls it."""
    content: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(plan)))
    content["configuration"] = content.pop("config")
    parts = {**content, **content.pop("options")}
    return {name.replace("_", " "): value for name, value in parts.items() if name != "options"}


def _read_manifest(text: str, source: Path) -> pa.Table:
    first = text.split("\n", 1)[0]
    delimiter = ";" if ";" in first else ","
    reader = csv.DictReader(io.StringIO(text), delimiter=delimiter, skipinitialspace=True)
    if "input" not in (reader.fieldnames or []):
        raise PlanError(f"{source} has no column input: give a CSV with the columns input[,truth]")
    rows = [(row["input"].strip(), (row.get("truth") or "").strip()) for row in reader if (row["input"] or "").strip()]
    if not rows:
        raise PlanError(f"{source} lists no recording: add a line with the path of one")
    doubled = [name for name, count in Counter(name for name, _ in rows).items() if count > 1]
    if doubled:
        raise PlanError(f"{source} lists {doubled[0]} twice" + (f", and {len(doubled) - 1} more" if doubled[1:] else ""))
    base = source.resolve().parent
    columns = {
        "recording": [name for name, _ in rows],
        "input": [_absolute(name, base) for name, _ in rows],
        "truth": [_absolute(truth, base) if truth else None for _, truth in rows],
    }
    return pa.table(columns, schema=pa.schema([(name, pa.string()) for name in columns]))


def _absolute(name: str, base: Path) -> str:
    return name if "://" in name else os.path.join(base, name)
