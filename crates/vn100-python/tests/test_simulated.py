"""Samples with known noise, and what is measured of them."""

import numpy as np
import pytest
import vn100

TRUTH = {"gyro_x": {"N": 1e-4, "mean": 0.01}, "accel_z": {"N": 1e-3, "K": 1e-3, "mean": -9.8}, "value": {"N": 2.0, "B": 1.0}}


def test_the_truth_is_measured():
    run = vn100.simulate(TRUTH, seconds=1800, rate=50, seed=7)
    assert list(run) == list(TRUTH) and run.rate == 50 and len(run["value"]) == 90_000
    assert run.truth["gyro_x"] == {"mean": 0.01, "N": 1e-4, "B": 0.0, "K": 0.0, "R": 0.0}
    analyzer = vn100.Analyzer(list(run), rate=run.rate)
    analyzer.push(run)
    result = analyzer.result()
    assert result["gyro_x"].noise.white.value == pytest.approx(1e-4, rel=0.03)
    assert result["accel_z"].noise.rate_random_walk.value == pytest.approx(1e-3, rel=0.3)
    taus, found, _, _ = vn100.oadev(run["value"], 50, "freq", [0.02])
    assert found[0] == pytest.approx(2.0 / np.sqrt(0.02), rel=0.05)


def test_a_seed_gives_the_same_numbers_and_another_one_others():
    one, same, other = (vn100.simulate(TRUTH, seconds=1, rate=100, seed=seed)["gyro_x"] for seed in (1, 1, 2))
    assert np.array_equal(one, same) and not np.array_equal(one, other)


@pytest.mark.parametrize(
    ("terms", "match"),
    [({"n": 1.0}, "'n' is none of"), ({"N": -1.0}, "does not exist"), ({"mean": float("nan")}, "does not exist")],
)
def test_terms_that_do_not_exist_are_refused(terms, match):
    with pytest.raises(ValueError, match=match):
        vn100.simulate({"gyro_x": terms}, seconds=1, rate=100)


def test_curves_have_the_averaging_times_that_are_asked_for():
    run = vn100.simulate({"gyro_x": {"N": 1e-4}}, seconds=100, rate=10, seed=3)
    analyzer = vn100.Analyzer(["gyro_x"], rate=10, estimator="full", taus=[0.5, 3.0])
    analyzer.push(run)
    assert {0.5, 3.0} <= set(np.round(analyzer.result()["gyro_x"].curve.tau, 9))
    with pytest.raises(ValueError, match="estimator"):
        vn100.Analyzer(["gyro_x"], rate=10, taus=[0.5])
    with pytest.raises(ValueError, match="no multiple"):
        vn100.Analyzer(["gyro_x"], rate=10, estimator="full", taus=[0.55])
    with pytest.raises(ValueError, match="averaging time"):
        vn100.Analyzer(["gyro_x"], rate=10, estimator="full", taus="all")
