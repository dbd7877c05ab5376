"""The papers' filters on arrays, against the program's."""

from __future__ import annotations

import csv
import pickle

import numpy as np
import pytest

from seamtrack import _native, kalman

MODELS = {
    "white": kalman.ConstantVelocity(),
    "coloured-measurement": kalman.ColouredMeasurement(),
    "coloured-process": kalman.ColouredProcess(),
    "adaptive": kalman.Adaptive(),
}


def series(count=120):
    random = np.random.default_rng(3)
    times = 0.2 * np.arange(count) + 0.01 * random.uniform(-1, 1, count)
    y = 4.0 + 0.3 * times + 0.2 * np.sin(times) + random.normal(0.0, 0.1, count)
    y[40:44] = np.nan
    return np.round(times, 6), np.round(y, 6)


@pytest.mark.parametrize("model", MODELS)
def test_a_series_gives_the_programs_numbers(model, run_program, tmp_path):
    times, y = series()
    cells = ["" if np.isnan(value) else repr(float(value)) for value in y]
    rows = [f"{float(time_s)!r},{cell}" for time_s, cell in zip(times, cells, strict=True)]
    (tmp_path / "z.csv").write_text("\n".join(["time_s,z1", *rows]) + "\n")
    done = run_program("filter", "z.csv", "--model", model, "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "out" / "filter.csv", newline="") as file:
        theirs = list(csv.DictReader(file))
    ours = MODELS[model].filter(y, time_s=times)
    pairs = {"x": "x", "x_std": "x_std", "smooth_x": "smooth_x", "smooth_x_std": "smooth_x_std", "nis": "nis"}
    for name, column in pairs.items():
        expected = [float(row[column]) if row[column] else np.nan for row in theirs]
        np.testing.assert_allclose(getattr(ours, name), expected, rtol=1e-6, atol=1e-9, err_msg=name)


def test_what_is_not_given_is_as_printed():
    for name in ("white", "coloured-measurement", "coloured-process"):
        printed, ours = _native.model_parameters(name), MODELS[name]
        own = {key: value for key, value in vars(ours).items() if key != "period_s"}
        assert {key: printed[key] for key in own} == own


def test_a_fit_makes_the_series_likelier_and_models_are_values():
    times, y = series()
    given = kalman.ColouredMeasurement()
    fitted = given.fit(y, time_s=times)
    assert fitted.filter(y, time_s=times).log_likelihood > given.filter(y, time_s=times).log_likelihood + 10
    assert fitted.period_s == pytest.approx(np.median(np.diff(times)))
    assert pickle.loads(pickle.dumps(fitted)) == fitted
    with pytest.raises(AttributeError):
        fitted.white_variance = 1.0


def test_smoothing_lowers_sigma_and_a_lag_lies_between():
    _, y = series()
    whole = kalman.ConstantVelocity().filter(y, period_s=0.2)
    lagged = kalman.ConstantVelocity().filter(y, period_s=0.2, fixed_lag=3)
    middle = slice(20, 30)
    assert (whole.smooth_x_std[middle] < lagged.smooth_x_std[middle]).all()
    assert (lagged.smooth_x_std[middle] < whole.x_std[middle]).all()


def test_bad_series_are_refused_in_words():
    model = kalman.ConstantVelocity()
    cases = [
        (dict(y=[1.0, 2.0]), "time_s or period_s"),
        (dict(y=[1.0], period_s=0.1), "at least two"),
        (dict(y=[[1.0, 2.0]], period_s=0.1), r"shape \(n,\)"),
        (dict(y=[1.0, 2.0, 3.0], time_s=[0.0, 1.0]), "as many"),
        (dict(y=[1.0, 2.0, 3.0, 4.0], time_s=[0.0, 1.0, 1.0, 2.0]), "(?i)step|time"),
        (dict(y=[1.0, 2.0, 3.0], period_s=0.1, second=[1.0, 2.0, 3.0]), "leave the second out"),
        (dict(y=[1.0, 2.0, 3.0], period_s=0.1, fixed_lag=2000), "at most 1000"),
    ]
    for keys, words in cases:
        with pytest.raises(ValueError, match=words):
            model.filter(**keys)
    with pytest.raises(ValueError, match="variance"):
        kalman.ConstantVelocity(white_variance=-1.0).filter([1.0, 2.0, 3.0], period_s=0.1)
