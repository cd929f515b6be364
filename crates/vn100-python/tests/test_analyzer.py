"""Arrays as they come."""

import json
import threading

import numpy as np
import pytest
import vn100


def test_numbers_are_those_of_the_overlapping_deviation(noise):
    analyzer = vn100.Analyzer(["gyro_x"], rate=40.0, resolution=1e-6, estimator="full")
    analyzer.push(1e-6 * noise)
    curve = analyzer.curve("gyro_x")
    taus, deviations, _, ns = vn100.oadev(1e-6 * noise, rate=40.0, data_type="freq")
    np.testing.assert_allclose(curve.deviation[: len(taus)], deviations, rtol=1e-9)
    np.testing.assert_array_equal(curve.tau[: len(taus)], taus)
    np.testing.assert_array_equal(curve.terms[: len(ns)], ns)
    known = ~np.isnan(curve.edf)
    assert curve.unit == "rad/s" and known[0] and not known[-1]
    assert (curve.lower[known] < curve.deviation[known]).all() and (curve.deviation[known] < curve.upper[known]).all()


def test_white_noise_is_found():
    random = np.random.default_rng(1)
    analyzer = vn100.Analyzer(["accel_x", "temperature"], rate=100.0)
    rows = np.column_stack([9.81 + 1e-3 * random.standard_normal(200_000), 20 + random.standard_normal(200_000)])
    for block in np.array_split(rows, 17):
        analyzer.push(block)
    white = analyzer.noise("accel_x").white
    assert white.status == "estimated" and white.lower < 1e-4 < white.upper
    assert abs(white.value / 1e-4 - 1) < 0.02
    assert analyzer.noise("temperature") is None and analyzer.samples == 200_000
    spectrum = analyzer.result().channels["accel_x"]
    assert abs(np.median(spectrum.density) / 2e-8 - 1) < 0.1 and spectrum.frequency[-1] == 50.0


def test_the_division_of_rows_changes_no_bit(noise):
    rows = np.column_stack([noise, noise[::-1]]).astype(float)
    documents = []
    for parts in (1, 3, 50):
        analyzer = vn100.Analyzer(["gyro_x", "other"], rate=40.0, resolution=[1.0, 1.0])
        for block in np.array_split(rows, parts):
            analyzer.push(block)
        documents.append(json.dumps(analyzer.to_dict()))
    assert documents[0] == documents[1] == documents[2]


def test_missing_rows_are_counted_and_so_are_missing_numbers(noise):
    rows = np.column_stack([noise, noise]).astype(float)
    rows[100:110] = np.nan
    rows[200, 1] = np.nan
    analyzer = vn100.Analyzer(["gyro_x", "gyro_y"], rate=40.0, resolution=1.0)
    analyzer.push(rows)
    result = analyzer.result()
    assert (result.samples, result.missing) == (4990, 10)
    assert [result.channels[name].count for name in ("gyro_x", "gyro_y")] == [4990, 4989]
    by_gap = vn100.Analyzer(["gyro_x"], rate=40.0, resolution=1.0)
    by_gap.push(rows[:100, 0])
    by_gap.gap(10)
    by_gap.push(rows[110:, 0])
    np.testing.assert_array_equal(by_gap.curve("gyro_x").deviation, result.channels["gyro_x"].curve.deviation)


def test_what_is_known_of_the_sensor_is_given():
    random = np.random.default_rng(2)
    rows = 1e-5 * random.standard_normal(100_000) + np.cumsum(1e-6 * random.standard_normal(100_000))
    for compensated, status in [("yes", "not-measurable"), (True, "not-measurable"), ("no", "estimated"), (False, "estimated")]:
        analyzer = vn100.Analyzer(["gyro_x"], rate=40.0, compensated=compensated)
        analyzer.push(rows)
        assert analyzer.noise("gyro_x").rate_random_walk.status == status


def test_a_thread_may_push_while_another_asks(noise):
    analyzer = vn100.Analyzer(["gyro_x", "gyro_y", "gyro_z"], rate=40.0, resolution=1.0)
    rows = np.column_stack([noise, noise, noise])[:4]
    analyzer.push(rows)
    done, failed = threading.Event(), []

    def push():
        for _ in range(2000):
            try:
                analyzer.push(rows)
            except RuntimeError as error:
                failed.append(error)
        done.set()

    thread = threading.Thread(target=push)
    thread.start()
    while not done.is_set():
        assert analyzer.result().samples % 4 == 0
    thread.join()
    assert not failed and analyzer.samples == analyzer.result().samples == 8004


def test_a_result_is_kept_until_rows_follow(noise):
    analyzer = vn100.Analyzer(["gyro_x"], rate=40.0, resolution=1.0)
    analyzer.push(noise)
    result = analyzer.result()
    assert analyzer.curve("gyro_x") is result.channels["gyro_x"].curve
    analyzer.push(noise)
    assert analyzer.result().samples == 2 * result.samples == 10_000
    assert repr(analyzer) == "<vn100.Analyzer: 10000 samples at 40 Hz, 1 channels>"


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"channels": ["a", "a"]}, ValueError, "twice"),
        ({"channels": []}, ValueError, "name a channel"),
        ({"rate": 0.0}, ValueError, "0 Hz"),
        ({"rate": -1.0}, ValueError, "-1 Hz"),
        ({"rate": float("nan")}, ValueError, "Hz"),
        ({"resolution": 0.0}, ValueError, "above 0"),
        ({"resolution": [1.0, 2.0]}, ValueError, "one number"),
        ({"resolution": "x"}, TypeError, "no real numbers"),
        ({"confidence": 1.0}, ValueError, "between 0 and 1"),
        ({"estimator": "all"}, ValueError, "estimator"),
        ({"compensated": "perhaps"}, ValueError, 'compensated: "perhaps"'),
    ],
)
def test_options_that_do_not_exist_are_said(options, error, words):
    with pytest.raises(error, match=words):
        vn100.Analyzer(**{"channels": ["a"], "rate": 1.0} | options)


@pytest.mark.parametrize(
    ("rows", "error", "words"),
    [
        ([1.0, 2.0, 3.0], ValueError, "2 channels"),
        ([[[1.0]]], ValueError, "3 dimensions"),
        ([[1e9, 1.0]], ValueError, "give resolution"),
        ([[2.0, 1.0]] * 70_000 + [[np.inf, 1.0]], ValueError, "inf in row 70000"),
        ([["x", 1.0]], TypeError, "no real numbers"),
        (None, TypeError, "no real numbers"),
        ([[1.0, 1j]], TypeError, "complex"),
    ],
)
def test_rows_that_cannot_be_counted_are_said_and_none_is_taken(rows, error, words):
    analyzer = vn100.Analyzer(["a", "b"], rate=1.0)
    analyzer.push([[1.0, 1.0]])
    with pytest.raises(error, match=words):
        analyzer.push(rows)
    analyzer.push(np.empty((0, 2)))
    assert analyzer.samples == 1


def test_what_no_row_says_is_not_guessed():
    analyzer = vn100.Analyzer(["gyro_x"], rate=1.0, resolution=np.float32(0.5))
    with pytest.raises(ValueError, match="no row"):
        analyzer.curve("gyro_x")
    with pytest.raises(KeyError, match="none of the channels gyro_x"):
        analyzer.noise("gyro_y")
    for gap in (-1, 2**60):
        with pytest.raises(ValueError, match="no number of samples"):
            analyzer.gap(gap)
    # rows that are all missing do not say what a count is worth, and neither do zeros
    late = vn100.Analyzer(["gyro_x"], rate=1.0)
    late.push([np.nan, np.nan])
    late.push([1e-3, -1e-3, np.nan, 2e-3])
    assert (late.samples, late.result().missing) == (3, 1), "a record begins with its first sample"
    assert late.curve("gyro_x").deviation[0] > 0
    zeros = vn100.Analyzer(["gyro_x"], rate=1.0)
    zeros.push(np.zeros(10))
    with pytest.raises(ValueError, match="all 0 or missing, and 0.001 in row 1"):
        zeros.push([0.0, 1e-3])
    assert zeros.samples == 10 and (zeros.curve("gyro_x").deviation == 0).all()
    for odd in (1e-300, 1e300):
        with pytest.raises(ValueError, match="scale them"):
            vn100.Analyzer(["gyro_x"], rate=1.0).push([odd, -odd])
    with pytest.raises(ValueError, match="gyro_x: inf in row 1 is not finite"):
        vn100.Analyzer(["gyro_x"], rate=1.0).push([np.nan, np.inf])
    masked = vn100.Analyzer(["gyro_x"], rate=1.0, resolution=1.0)
    masked.push(np.ma.masked_array([1.0, 2.0, 3.0], mask=[0, 1, 0]))
    assert (masked.samples, masked.result().missing) == (2, 1)
