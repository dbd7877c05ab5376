"""Live frames."""

from __future__ import annotations

import copy
import pickle
import threading

import numpy as np
import pytest

import seamtrack


@pytest.fixture(scope="module")
def rendered():
    return seamtrack.synth.render("A-butt", seed=5, frames=30)


def follow(session, frames, times):
    return [session.step(frame, time_s) for frame, time_s in zip(frames, times, strict=True)]


def test_steps_give_the_path_of_the_whole_recording(rendered, short):
    frames, truth = rendered
    session = seamtrack.Session(seamtrack.Sensor(0.073), joint="auto")
    estimates = follow(session, frames, truth.time_s)
    run = seamtrack.track(short, mm_per_px=0.073)
    assert [estimate.status for estimate in estimates] == run["status"].tolist()
    ours = [np.nan if estimate.u_px is None else estimate.u_px for estimate in estimates]
    np.testing.assert_allclose(ours, run["u_px"], atol=5.01e-4)
    assert session.joint["kind"] == run.joint["kind"] and session.stripe == "horizontal"
    assert abs(estimates[-1].u_px - truth.u_px[-1]) < 1.0
    assert estimates[-1].lateral_mm == pytest.approx(0.073 * estimates[-1].u_px)


def test_any_layout_of_a_frame_is_the_same_frame(rendered):
    frames, truth = rendered
    plain = follow(seamtrack.Session(), frames, truth.time_s)
    wide = np.zeros((30, 480, 1280), np.uint8)
    wide[:, :, ::2] = frames
    assert follow(seamtrack.Session(), wide[:, :, ::2], truth.time_s) == plain
    turned = [np.asfortranarray(frame) for frame in frames]
    assert follow(seamtrack.Session(), turned, truth.time_s) == plain
    readonly = frames.copy()
    readonly.flags.writeable = False
    assert follow(seamtrack.Session(), readonly, truth.time_s) == plain


def test_sixteen_bits_are_brought_to_eight_by_the_depth_that_is_used(rendered):
    frames, truth = rendered
    deep = frames.astype(np.uint16) * 16
    given = seamtrack.Session(white=255 * 16)
    plain = follow(seamtrack.Session(), frames, truth.time_s)
    assert follow(given, deep, truth.time_s) == plain
    session = seamtrack.Session()
    session.step(np.zeros_like(deep[0]), -1.0)
    found = follow(session, deep, truth.time_s)
    assert session.white == 4095
    assert [estimate.status for estimate in found[-20:]] == ["tracked"] * 20
    assert all(abs(a.u_px - b.u_px) < 0.5 for a, b in zip(found[-20:], plain[-20:], strict=True))


def test_what_is_no_frame_is_refused_in_words(rendered):
    session = seamtrack.Session()
    for frame, words in [
        (rendered.frames, "uint8 with 3 dimensions"),
        (rendered.frames[0].astype(np.float32), "an array of float32 with 2 dimensions"),
        ([[1, 2], [3, 4]], "list"),
        (None, "NoneType"),
    ]:
        with pytest.raises(TypeError, match=words):
            session.step(frame, 0.0)
    session.step(rendered.frames[0], 0.0)
    with pytest.raises(ValueError, match="start a new session"):
        session.step(np.zeros((10, 12), np.uint8), 1.0)
    with pytest.raises(ValueError, match="needs at least one pixel"):
        seamtrack.Session().step(np.zeros((0, 12), np.uint8), 1.0)
    with pytest.raises(ValueError, match="white"):
        seamtrack.Session(white=0)
    with pytest.raises(TypeError):
        seamtrack.Session(white=70_000.5)


def test_a_miss_and_a_bad_stamp_are_told(rendered):
    frames, truth = rendered
    session = seamtrack.Session()
    follow(session, frames, truth.time_s)
    end = truth.time_s[-1]
    assert session.miss(end + 0.2).status == "coasting"
    assert session.step(frames[-1] ^ 1, end).observation == "bad-stamp"
    assert session.step(frames[-1] ^ 2, float("nan")).observation == "bad-stamp"


def test_estimates_are_values(rendered):
    frames, truth = rendered
    estimate = follow(seamtrack.Session(), frames, truth.time_s)[-1]
    assert pickle.loads(pickle.dumps(estimate)) == estimate == copy.deepcopy(estimate)
    assert repr(estimate).startswith("<Estimate tracked, u_px=")
    with pytest.raises(AttributeError):
        estimate.u_px = 3.0


def test_sessions_run_in_threads_of_their_own_and_one_may_be_shared(rendered):
    frames, truth = rendered
    plain = follow(seamtrack.Session(), frames, truth.time_s)
    results = {}

    def work(name):
        results[name] = follow(seamtrack.Session(), frames, truth.time_s)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(result == plain for result in results.values())
    shared = seamtrack.Session()
    threads = [threading.Thread(target=lambda: [shared.step(frame, 0.0) for frame in frames]) for _ in range(3)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert shared.step(frames[0], 100.0).status in {"seeking", "tracked", "coasting", "lost"}


def test_a_session_keeps_its_settings():
    session = seamtrack.Session(seamtrack.Sensor(0.1), config=seamtrack.Config(joint="lap"), stripe="vertical")
    assert session.config == seamtrack.Config(joint="lap", stripe="vertical")
    assert session.sensor == seamtrack.Sensor(0.1) and "no joint yet" in repr(session)
