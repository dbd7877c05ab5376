"""Whole recordings: the same numbers as the program's, and what can be done with them."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import seamtrack

CASES = {
    "demo-butt": ("fixtures/demo-butt", ["--mm-per-px", "0.073"], {"mm_per_px": 0.073}),
    "demo-butt-paper": ("fixtures/demo-butt", ["--preset", "paper"], {"preset": "paper"}),
    "demo-butt-lag": ("fixtures/demo-butt", ["--fixed-lag", "5"], {"fixed_lag": 5}),
    "demo-hairline": ("fixtures/demo-hairline", ["--mm-per-px", "0.217"], {"mm_per_px": 0.217}),
}


@pytest.mark.parametrize("case", CASES)
def test_a_recording_of_the_repository_gives_the_programs_path_and_summary(case, run_program, root, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    recording, options, keys = CASES[case]
    truth = f"{recording}/truth.csv"
    done = run_program("track", recording, "--truth", truth, *options, "-o", tmp_path / "out", "--quiet")
    assert done.returncode in (0, 3), done.stderr
    run = seamtrack.track(recording, truth=truth, **keys)
    assert run.to_csv() == (tmp_path / "out" / "path.csv").read_bytes()
    theirs = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert {**run.summary, "timing": None} == {**theirs, "timing": None}
    assert (run.verdict == "bad") == (done.returncode == 3)


def test_what_a_configuration_and_a_calibration_decide_is_the_programs_too(run_program, root, tmp_path):
    seamtrack.synth.write("sensor-vgroove", tmp_path / "rec", frames=40)
    calibration = root / "fuzz/corpus/calibration/scale.toml"
    (tmp_path / "c.toml").write_text('joint = "vgroove"\nspeed_mm_s = 4.0\n')
    arguments = ["--config", "c.toml", "--calibration", calibration, "--frames", "3..", "--tolerance", "0.4", "--origin", "centre"]
    done = run_program("track", "rec", *arguments, "-o", "out", "--quiet", cwd=tmp_path)
    assert done.returncode in (0, 3), done.stderr
    run = seamtrack.track(
        tmp_path / "rec",
        config=seamtrack.Config.read(tmp_path / "c.toml"),
        sensor=seamtrack.calib.load(calibration),
        frames="3..",
        tolerance_mm=0.4,
        origin="centre",
    )
    assert run.to_csv() == (tmp_path / "out" / "path.csv").read_bytes()
    theirs = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert run.summary["tolerance"] == theirs["tolerance"]
    assert run.summary["frames"] == theirs["frames"]


def test_columns_are_those_of_path_csv_and_tables_know_what_is_missing(short):
    pandas, pyarrow = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    run = seamtrack.track(short)
    names = run.to_csv().decode().splitlines()[0].split(",")
    assert list(run.columns) == names
    assert len(run) == 30 and all(len(column) == 30 for column in run.columns.values())
    frame = run.to_pandas()
    assert list(frame) == names and frame["template_updated"].dtype == "boolean"
    read = pandas.read_csv(pandas.io.common.BytesIO(run.to_csv()))
    np.testing.assert_array_equal(frame["u_px"], read["u_px"])
    table = run.to_arrow()
    # Without a scale there are no millimetres: nothing, not a number that is none.
    assert table["x_mm"].null_count == 30 and table["x_mm"].type == pyarrow.float64()
    assert run.unit == "px" and np.isnan(run["x_mm"]).all()


def test_a_run_tells_its_verdict_joint_and_smoothed_path(short):
    run = seamtrack.track(short, mm_per_px=0.073, truth=short / "truth.csv")
    assert run.verdict == "good" and run.joint["kind"] == "butt"
    assert repr(run) == f"<Run GOOD: {run.sentence} Joint: butt.>"
    assert run.summary["errors"]["smoothed"]["max_mm" if "max_mm" in run.summary["errors"]["smoothed"] else "max"] < 0.1
    assert set(run.smoothed) == {"u_px", "v_px", "std_px", "x_mm", "x_std_mm"}
    assert np.isfinite(run.smoothed["x_mm"]).all()


def test_a_run_is_a_picture_in_a_notebook(short, tmp_path):
    pytest.importorskip("matplotlib").use("agg")
    frames, truth = seamtrack.synth.render("A-butt", seed=5, frames=30)
    run = seamtrack.track(short, mm_per_px=0.073)
    html = run._repr_html_()
    assert html.count("<polyline") == 2 and "GOOD" in html and "<script" not in html
    axes = run.plot(truth=truth._asdict())
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["± 2 σ", "filtered", "smoothed", "truth"]
    axes.figure.savefig(tmp_path / "run.png")
    nothing = tmp_path / "dark"
    nothing.mkdir()
    for name in ("1.png", "2.png"):
        (nothing / name).write_bytes(dark_png())
    dark = seamtrack.track(nothing)
    assert dark.verdict == "bad" and "<svg" in dark._repr_html_() and "<polyline" not in dark._repr_html_()


def dark_png() -> bytes:
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress((b"\0" + bytes(64)) * 64)
    header = struct.pack(">IIBBBBB", 64, 64, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def test_settings_and_results_can_be_pickled(short, root):
    run = seamtrack.track(short, mm_per_px=0.073)
    again = pickle.loads(pickle.dumps(run))
    assert again.to_csv() == run.to_csv() and again.summary == run.summary and repr(again) == repr(run)
    for config in (seamtrack.Config(), seamtrack.Config(joint="lap", paper={"median_px": 3}), seamtrack.Config(period_s=0.2)):
        assert pickle.loads(pickle.dumps(config)) == config
    calibration = seamtrack.calib.load(root / "fuzz/corpus/calibration/sensor.toml")
    for sensor in (seamtrack.Sensor(), seamtrack.Sensor(0.073, source="a ruler"), calibration):
        assert pickle.loads(pickle.dumps(sensor)) == sensor


def test_a_frame_that_cannot_be_read_does_not_end_a_run(short, tmp_path):
    import shutil

    shutil.copytree(short / "frames", tmp_path / "frames")
    broken = sorted((tmp_path / "frames").iterdir())[7]
    broken.write_bytes(broken.read_bytes()[:50])
    run = seamtrack.track(tmp_path / "frames")
    assert run["status"][7] == "unreadable" and run.summary["frames"]["unreadable"] == 1
    assert any(broken.name in note for note in run.notes)


def test_errors_are_exceptions_in_the_programs_words(short, tmp_path, run_program):
    missing = tmp_path / "nowhere"
    with pytest.raises(FileNotFoundError) as error:
        seamtrack.track(missing)
    assert str(error.value) in run_program("track", missing, "-o", tmp_path / "out").stderr
    cases = [
        (dict(joint="weld"), "unknown variant `weld`"),
        (dict(no_such_key=1), "unknown field `no_such_key`"),
        (dict(period_s=-1.0), "period_s must be between"),
        (dict(frames="9..3"), "expected A..B"),
        (dict(origin="left"), "expected first, centre or a pixel"),
        (dict(seed_at=(9000, 10)), "lies outside the frames of 640 x 480 pixels"),
        (dict(tolerance_mm=0.3), "give mm_per_px or a sensor"),
        (dict(mm_per_px=float("nan")), "a number is not finite"),
    ]
    for keys, words in cases:
        with pytest.raises(ValueError, match="(?i)" + words.replace("(", r"\(").replace("..", r"\.\.")):
            seamtrack.track(short, **keys)
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="holds no png, jpg, bmp or tif image"):
        seamtrack.track(tmp_path / "empty")


def test_configurations_say_what_differs_from_the_default_one():
    config = seamtrack.Config(joint="butt", mm_per_px=0.073, paper={"median_px": 3})
    assert repr(config) == 'Config(joint="butt", mm_per_px=0.073, paper={"median_px": 3})'
    assert config.replace(joint="auto", paper={"lambda": 0.001}).to_dict()["paper"]["median_px"] == 3
    assert eval(repr(config), {"Config": seamtrack.Config}) == config
    assert seamtrack.Config() == seamtrack.Config(joint="auto")


def test_tracking_lets_other_threads_run(short):
    import threading

    ticks, done = 0, threading.Event()

    def track() -> None:
        seamtrack.track(short)
        done.set()

    thread = threading.Thread(target=track)
    thread.start()
    while not done.wait(0.001):
        ticks += 1
    thread.join()
    assert ticks > 3


def test_the_package_says_where_the_path_of_a_recording_lies(short):
    for recording in (short, str(short), Path(short) / "frames"):
        assert len(seamtrack.track(recording)) == 30
