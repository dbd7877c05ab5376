"""Recordings in an object store: a local S3 server."""

from __future__ import annotations

import tarfile

import numpy as np
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

import seamtrack
from seamtrack import fleet

moto = pytest.importorskip("moto.server")
s3fs = pytest.importorskip("s3fs")


@pytest.fixture
def endpoint(monkeypatch):
    server = moto.ThreadedMotoServer(port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    # How fsspec is told of a store of one's own.
    import fsspec.config

    monkeypatch.setitem(fsspec.config.conf, "s3", {"endpoint_url": f"http://{host}:{port}"})
    yield f"http://{host}:{port}"
    server.stop()


def test_folders_and_tar_shards_in_a_bucket_are_tracked(endpoint, tmp_path):
    store = s3fs.S3FileSystem(endpoint_url=endpoint)
    store.mkdir("weld")
    for number in range(3):
        seamtrack.synth.write("A-butt", tmp_path / f"r{number}", seed=number + 1, frames=12)
    store.put(str(tmp_path / "r0") + "/", "weld/monday/r0/", recursive=True)
    with tarfile.open(tmp_path / "night.tar", "w") as tar:
        for number in (1, 2):
            tar.add(tmp_path / f"r{number}", f"r{number}")
    store.put(str(tmp_path / "night.tar"), "weld/night.tar")
    names = ["s3://weld/monday/r0", "s3://weld/night.tar::r1", "s3://weld/night.tar::r2", "s3://weld/monday/r9"]
    (tmp_path / "list.csv").write_text("\n".join(["input", *names]) + "\n")
    report = fleet.run(tmp_path / "list.csv", tmp_path / "out", mm_per_px=0.073)
    assert report.is_complete and report.failures == 1 and report.frames == 36, str(report)
    frames = pq.read_table(tmp_path / "out" / "frames")
    for number, name in enumerate(names[:3]):
        own = frames.filter(pc.equal(frames["recording"], name))
        alone = seamtrack.track(tmp_path / f"r{number}", mm_per_px=0.073)
        np.testing.assert_array_equal(own["u_px"].to_numpy(), alone["u_px"])


def test_a_store_that_does_not_answer_is_no_failure_of_the_recording(monkeypatch, tmp_path):
    import fsspec.config

    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "test")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    settings = {"endpoint_url": "http://127.0.0.1:9", "config_kwargs": {"retries": {"max_attempts": 0}, "connect_timeout": 1}}
    monkeypatch.setitem(fsspec.config.conf, "s3", settings)
    (tmp_path / "list.csv").write_text("input\ns3://weld/r0\n")
    fleet.plan(tmp_path / "list.csv", tmp_path / "out")
    with pytest.raises(Exception, match="(?i)connect"):
        fleet.shard(tmp_path / "out", 0)
    assert fleet.check(tmp_path / "out").missing_shards == 1
