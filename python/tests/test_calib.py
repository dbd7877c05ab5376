"""Pixels to millimetres."""

from __future__ import annotations

import numpy as np
import pytest

from seamtrack import Sensor, calib


@pytest.fixture(scope="module")
def plane(root):
    return calib.load(root / "fuzz/corpus/calibration/sensor.toml")


def test_a_calibrated_plane_gives_millimetres_with_their_jacobians(plane):
    assert plane.kind == "plane" and "sensor.toml" in repr(plane)
    uv = np.array([[400.0, 300.0], [500.0, 320.0], [350.5, 280.25]])
    points, jacobians = plane.to_plane(uv)
    assert points.shape == (3, 2) and jacobians.shape == (3, 2, 2)
    np.testing.assert_allclose(plane.to_pixel(points), uv, atol=1e-6)
    for column in (0, 1):
        step = np.zeros(2)
        step[column] = 0.01
        numeric = (plane.to_plane(uv + step)[0] - plane.to_plane(uv - step)[0]) / 0.02
        np.testing.assert_allclose(jacobians[:, :, column], numeric, rtol=1e-5, atol=1e-8)
    assert plane.is_calibrated(uv).dtype == bool
    covariance = plane.calibration_covariance(uv)
    assert covariance.shape == (3, 2, 2)


def test_pictures_that_were_cut_out_show_the_same_points(plane):
    uv = np.array([[400.0, 300.0], [500.0, 320.0]])
    cut = plane.cropped((120, 40), (500, 400))
    np.testing.assert_allclose(cut.to_plane(uv - [120, 40])[0], plane.to_plane(uv)[0], atol=1e-9)
    with pytest.raises(ValueError):
        plane.cropped((120, 40), (50_000, 400))


def test_one_scale_knows_how_the_stripe_runs():
    points, jacobians = Sensor(0.5).to_plane([[10, 20]])
    assert points.tolist() == [[5.0, 10.0]] and jacobians.tolist() == [[[0.5, 0.0], [0.0, 0.5]]]
    points, jacobians = Sensor(0.5).to_plane([[10, 20]], stripe="vertical")
    assert points.tolist() == [[10.0, 5.0]] and jacobians.tolist() == [[[0.0, 0.5], [0.5, 0.0]]]
    assert Sensor().to_plane(np.empty((0, 2)))[0].shape == (0, 2)


def test_what_is_no_sensor_is_refused_in_words(root, tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere.toml"):
        calib.load(tmp_path / "nowhere.toml")
    (tmp_path / "bad.toml").write_text("schema_version = 1\n[camera]\n")
    with pytest.raises(ValueError, match="bad.toml"):
        calib.load(tmp_path / "bad.toml")
    with pytest.raises(ValueError):
        Sensor(-1.0)
    with pytest.raises(ValueError, match=r"shape \(n, 2\)"):
        Sensor(1.0).to_plane([[1, 2, 3]])
    with pytest.raises(ValueError, match="horizontal or vertical"):
        Sensor(1.0).to_plane([[1, 2]], stripe="diagonal")
