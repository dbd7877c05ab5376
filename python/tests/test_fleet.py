"""Thousands of recordings, in small: exactly once, whole or not at all, and nothing mixed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tarfile
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

import seamtrack

pa = pytest.importorskip("pyarrow")
pytest.importorskip("fsspec")
import pyarrow.compute as pc  # noqa: E402
import pyarrow.parquet as pq  # noqa: E402

from seamtrack import fleet  # noqa: E402
from seamtrack.fleet.__main__ import main  # noqa: E402


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    """Six short recordings in two kinds of places, a missing one, a broken one, and their manifest."""
    folder = tmp_path_factory.mktemp("recordings")
    for number in range(6):
        seamtrack.synth.write("A-butt", folder / f"r{number}", seed=number + 1, frames=12)
    (folder / "broken").mkdir()
    (folder / "broken" / "1.png").write_bytes(b"no picture")
    lines = ["input;truth", *(f"r{i};r{i}/truth.csv" for i in range(6)), "nowhere;", "broken;"]
    (folder / "list.csv").write_text("\n".join(lines) + "\n")
    return folder


def tables(out: Path) -> tuple[pa.Table, pa.Table]:
    return pq.read_table(out / "recordings"), pq.read_table(out / "frames")


def run(recordings: Path, out: Path, **more) -> fleet.Report:
    return fleet.run(recordings / "list.csv", out, shard_size=3, mm_per_px=0.073, **more)


def test_a_manifest_becomes_two_tables_and_a_page(recordings, tmp_path):
    report = run(recordings, tmp_path / "out", jobs=2)
    assert report.is_complete and (report.recordings, report.failures, report.frames) == (8, 2, 72), str(report)
    rows, frames = tables(tmp_path / "out")
    table = {row["recording"]: row for row in rows.to_pylist()}
    assert "cannot open nowhere" in table["nowhere"]["failure"]
    assert "broken" in table["broken"]["failure"] and table["broken"]["verdict"] is None
    good = table["r0"]
    assert good["verdict"] == "good" and good["joint"] == "butt" and good["unit"] == "mm"
    assert good["filtered_mae"] < 0.05 and json.loads(good["summary"])["input"]["path"] == "r0"
    # The columns and numbers of path.csv.
    alone = seamtrack.track(recordings / "r3", mm_per_px=0.073)
    own = frames.filter(pc.equal(frames["recording"], "r3")).drop_columns(["recording"])
    assert own.column_names == list(alone.columns)
    np.testing.assert_array_equal(own["x_mm"].to_numpy(), alone["x_mm"])
    assert own["calibrated"].null_count == 12 and own["template_updated"].type == pa.bool_()
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.index("nowhere") < page.index(">r0") and "FAILED" in page and "mean error, filtered" in page


def test_a_run_goes_on_where_it_was_and_rewrites_nothing(recordings, tmp_path):
    out = tmp_path / "out"
    fleet.plan(recordings / "list.csv", out, shard_size=3, mm_per_px=0.073)
    assert fleet.shard(out, 1) == 3
    before = {file: file.stat().st_mtime_ns for file in out.rglob("0*.parquet")}
    assert not fleet.check(out).is_complete and fleet.check(out).missing_shards == 2
    assert fleet.shard(out, 1) == 0
    assert run(recordings, out).is_complete
    assert all(file.stat().st_mtime_ns == stamp for file, stamp in before.items()) and len(before) == 2


@pytest.mark.parametrize("jobs", [1, 3])
def test_frames_do_not_depend_on_threads(recordings, tmp_path, jobs):
    run(recordings, tmp_path / "a", jobs=2)
    run(recordings, tmp_path / "b", jobs=jobs)
    for file in sorted((tmp_path / "a" / "frames").iterdir()):
        assert file.read_bytes() == (tmp_path / "b" / "frames" / file.name).read_bytes()


def test_what_changed_since_is_refused_by_name(recordings, tmp_path, monkeypatch):
    out, manifest = tmp_path / "out", tmp_path / "list.csv"
    manifest.write_text((recordings / "list.csv").read_text().replace("r", str(recordings / "r"), 0))
    fleet.plan(manifest, out, shard_size=3, mm_per_px=0.073)
    assert fleet.plan(manifest, out, shard_size=3, mm_per_px=0.073).shards == 3
    refused = [
        (dict(mm_per_px=0.08), "another configuration"),
        (dict(mm_per_px=0.073, joint="lap"), "another configuration"),
        (dict(mm_per_px=0.073, sensor=seamtrack.Sensor(0.1)), "another sensor"),
        (dict(mm_per_px=0.073, origin="centre"), "another origin"),
        (dict(mm_per_px=0.073, shard_size=4), "another shard size"),
    ]
    for keys, words in refused:
        with pytest.raises(fleet.PlanError, match=words):
            fleet.plan(manifest, out, **{"shard_size": 3, **keys})
    manifest.write_text(manifest.read_text() + "one-more;\n")
    with pytest.raises(fleet.PlanError, match="another manifest"):
        fleet.plan(manifest, out, shard_size=3, mm_per_px=0.073)
    import seamtrack.fleet.shards as module

    monkeypatch.setattr(module, "program", lambda: "9.9.9+other")
    with pytest.raises(fleet.PlanError, match="another program"):
        fleet.shard(out, 0)


def test_a_manifest_that_is_none_is_refused_in_words(tmp_path):
    for text, words in [
        ("input\na\nb\na\n", "lists a twice"),
        ("input\n\n", "lists no recording"),
        ("file\na\n", "no column input"),
    ]:
        (tmp_path / "list.csv").write_text(text)
        with pytest.raises(fleet.PlanError, match=words):
            fleet.plan(tmp_path / "list.csv", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    with pytest.raises(fleet.PlanError, match="is missing"):
        fleet.check(tmp_path)


def test_a_check_finds_what_is_missing_doubled_strange_or_left_behind(recordings, tmp_path):
    out = tmp_path / "out"
    run(recordings, out)
    good = {file: file.read_bytes() for file in out.rglob("*.parquet")}

    def told(change) -> str:
        for file, content in good.items():
            file.write_bytes(content)
        change()
        report = fleet.check(out)
        assert not report.is_complete
        return str(report)

    first = out / "recordings" / "000000.parquet"
    frames = out / "frames" / "000000.parquet"
    assert "1 shards are not done" in told(first.unlink)
    assert "shard 0 cannot be read" in told(lambda: frames.write_bytes(b"PAR1"))
    assert "shard 0 cannot be read" in told(frames.unlink)
    assert "shards [1]" in told(lambda: first.write_bytes((out / "recordings" / "000001.parquet").read_bytes()))
    table = pq.read_table(frames)
    assert "r0: 11 frames" in told(lambda: pq.write_table(table.slice(1), frames))
    doubled = pa.concat_tables([table.slice(0, 1), table])
    assert "r0: 13 frames, 12 different ones" in told(lambda: pq.write_table(doubled, frames))
    stranger = out / "recordings" / "000077.parquet"
    assert "000077.parquet is no shard" in told(lambda: stranger.write_bytes(b""))
    stranger.unlink()
    for file, content in good.items():
        file.write_bytes(content)
    (out / "frames" / ".000001.parquet.abc.part").write_bytes(b"")
    report = fleet.check(out)
    assert report.is_complete and report.leftovers == ("frames/.000001.parquet.abc.part",)


def test_a_process_that_is_killed_leaves_whole_shards_only(recordings, tmp_path):
    out = tmp_path / "out"
    undisturbed = tmp_path / "undisturbed"
    run(recordings, undisturbed)
    arguments = ["run", recordings / "list.csv", "-o", out, "--shard-size", 3, "--mm-per-px", 0.073, "--jobs", 1]
    command = [sys.executable, "-m", "seamtrack.fleet", *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while not list((out / "recordings").glob("*.parquet")) and time.monotonic() < deadline:
        time.sleep(0.005)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    done = {file: (file.stat().st_mtime_ns, file.read_bytes()) for file in (out / "recordings").glob("*.parquet")}
    assert done
    subprocess.run(command, check=True, capture_output=True)
    assert all((file.stat().st_mtime_ns, file.read_bytes()) == before for file, before in done.items())
    for file in sorted((undisturbed / "frames").iterdir()):
        assert file.read_bytes() == (out / "frames" / file.name).read_bytes()


def test_recordings_lie_in_archives_and_stores_too(recordings, tmp_path):
    import fsspec

    with tarfile.open(tmp_path / "all.tar", "w") as tar:
        for number in range(3):
            tar.add(recordings / f"r{number}", f"./monday/{number}")
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        for file in sorted((recordings / "r3").rglob("*.png")):
            archive.write(file, f"r3/{file.name}")
    store = fsspec.filesystem("memory")
    store.put(str(recordings / "r4"), "/bucket/r4", recursive=True)
    store.put(str(tmp_path / "all.tar"), "/bucket/all.tar")
    names = [
        "all.tar::monday/0",
        "all.tar::monday/2/frames",
        "all.zip::r3",
        "memory://bucket/r4",
        "memory://bucket/all.tar::monday/1",
        "memory://bucket/nothing",
        "all.tar::tuesday",
    ]
    (tmp_path / "list.csv").write_text("\n".join(["input", *names]) + "\n")
    report = fleet.run(tmp_path / "list.csv", tmp_path / "out", shard_size=4)
    assert report.is_complete and report.failures == 2 and report.frames == 5 * 12, str(report)
    rows, frames = tables(tmp_path / "out")
    failures = {row["recording"]: row["failure"] for row in rows.to_pylist() if row["failure"]}
    assert "nothing there" in failures["memory://bucket/nothing"]
    assert "nothing of that name" in failures["all.tar::tuesday"]
    for name, number in [("all.tar::monday/0", 0), ("all.zip::r3", 3), ("memory://bucket/r4", 4)]:
        own = frames.filter(pc.equal(frames["recording"], name))
        np.testing.assert_array_equal(own["u_px"].to_numpy(), seamtrack.track(recordings / f"r{number}")["u_px"])


def test_an_archive_writes_nothing_outside_of_its_folder(tmp_path):
    with zipfile.ZipFile(tmp_path / "evil.zip", "w") as archive:
        archive.writestr("r/../../out.png", b"")
    (tmp_path / "list.csv").write_text("input\nevil.zip::r\n")
    fleet.run(tmp_path / "list.csv", tmp_path / "data")
    failure = tables(tmp_path / "data")[0]["failure"].to_pylist()[0]
    assert "outside of its own folder" in failure or "nothing of that name" in failure


def test_slurm_gets_an_array_whose_tasks_track_all_shards(recordings, tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    arguments = ["plan", recordings / "list.csv", "-o", out, "--shard-size", 1, "--sbatch", "--tasks", 3, "--at-once", 2]
    with pytest.raises(SystemExit) as left:
        main([*map(str, arguments), "--slurm-option=--mem=800"])
    assert left.value.code == 0
    script = (out / "fleet.sbatch").read_text()
    for line in ("#SBATCH --array=0-2%2", "#SBATCH --requeue", "#SBATCH --mem=800"):
        assert line in script.splitlines()
    for task in range(3):
        subprocess.run(["bash", str(out / "fleet.sbatch")], check=True, env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)}, capture_output=True)
    with pytest.raises(SystemExit) as left:
        main(["check", str(out)])
    assert left.value.code == 0 and "exactly once" in capsys.readouterr().out


def test_the_tables_can_be_queried(recordings, tmp_path):
    duckdb, polars = pytest.importorskip("duckdb"), pytest.importorskip("polars")
    run(recordings, tmp_path / "out")
    query = f"select joint, count(*), max(filtered_max) from '{tmp_path}/out/recordings/*.parquet' where failure is null group by joint"
    (joint, count, largest), = duckdb.sql(query).fetchall()
    assert (joint, count) == ("butt", 6) and largest < 0.2
    lazy = polars.scan_parquet(tmp_path / "out" / "frames" / "*.parquet")
    per = lazy.group_by("recording").agg(polars.len()).collect()
    assert sorted(per["len"]) == [12] * 6


def test_the_commands_say_what_is_wrong(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["check", str(tmp_path)])
    assert "plan.json is missing" in str(left.value.code)
