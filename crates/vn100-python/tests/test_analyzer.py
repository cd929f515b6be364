"""Arrays as they come."""

import json
import threading

import numpy as np
import pytest
import vn100


def test_numbers_are_those_of_the_overlapping_deviation(noise):
    analyzer = vn100.Analyzer(["gyro_x"], rate=40.0, resolution=1e-6, estimator="full")
    analyzer.push(1e-6 * noise)
    curve = analyzer.result()["gyro_x"].curve
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
    white = analyzer.result()["accel_x"].noise.white
    assert white.status == "estimated" and white.lower < 1e-4 < white.upper
    assert abs(white.value / 1e-4 - 1) < 0.02
    assert analyzer.result()["temperature"].noise is None and analyzer.samples == 200_000
    spectrum = analyzer.result()["accel_x"]
    assert abs(np.median(spectrum.density) / 2e-8 - 1) < 0.1 and spectrum.frequency[-1] == 50.0


def test_the_division_of_rows_changes_no_bit(noise):
    rows = np.column_stack([noise, noise[::-1]]).astype(float)
    documents = []
    for parts in (1, 3, 50):
        analyzer = vn100.Analyzer(["gyro_x", "other"], rate=40.0, resolution=[1.0, 1.0])
        for block in np.array_split(rows, parts):
            analyzer.push(block)
        documents.append(json.dumps(analyzer.result().to_dict()))
    assert documents[0] == documents[1] == documents[2]


def test_missing_rows_are_counted_and_so_are_missing_numbers(noise):
    rows = np.column_stack([noise, noise]).astype(float)
    rows[100:110] = np.nan
    rows[200, 1] = np.nan
    analyzer = vn100.Analyzer(["gyro_x", "gyro_y"], rate=40.0, resolution=1.0)
    analyzer.push(rows)
    result = analyzer.result()
    assert (result.samples, result.missing) == (4990, 10)
    assert [result[name].count for name in ("gyro_x", "gyro_y")] == [4990, 4989]
    by_gap = vn100.Analyzer(["gyro_x"], rate=40.0, resolution=1.0)
    by_gap.push(rows[:100, 0])
    by_gap.gap(10)
    by_gap.push(rows[110:, 0])
    np.testing.assert_array_equal(by_gap.result()["gyro_x"].curve.deviation, result["gyro_x"].curve.deviation)


def test_what_is_known_of_the_sensor_is_given():
    random = np.random.default_rng(2)
    rows = 1e-5 * random.standard_normal(100_000) + np.cumsum(1e-6 * random.standard_normal(100_000))
    for compensated, status in [("yes", "not-measurable"), (True, "not-measurable"), ("no", "estimated"), (False, "estimated")]:
        analyzer = vn100.Analyzer(["gyro_x"], rate=40.0, compensated=compensated)
        analyzer.push(rows)
        assert analyzer.result()["gyro_x"].noise.rate_random_walk.status == status


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
    assert analyzer.result()["gyro_x"].curve is result["gyro_x"].curve
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
        ({"rate": True}, TypeError, "rate: True"),
        ({"channels": ["Gyro_x"]}, ValueError, "Gyro_x: call the channel gyro_x"),
        ({"channels": ["gyroX"]}, ValueError, "call the channel gyro_x"),
        ({"channels": ["wx"]}, ValueError, "call the channel gyro_x"),
        ({"channels": ["imu_acc_z"]}, ValueError, "call the channel accel_z"),
        ({"channels": ["AngularVelocityY"]}, ValueError, "call the channel gyro_y"),
        ({"units": {"a": "deg"}}, ValueError, "units: 'deg' is none of"),
        ({"units": {"b": "deg/s"}}, ValueError, "units: b is none of the channels a"),
        ({"channels": ["gyro_x"], "units": {"gyro_x": "mg"}}, ValueError, "mg is no unit of gyro_x"),
        ({"quantity": "speed"}, ValueError, "quantity: 'speed'"),
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
    analyzer.push([[1.0, 1.0]] * 1000)
    with pytest.raises(error, match=words):
        analyzer.push(rows)
    analyzer.push(np.empty((0, 2)))
    assert analyzer.samples == 1000


def test_what_no_row_says_is_not_guessed():
    analyzer = vn100.Analyzer(["gyro_x"], rate=1.0, resolution=np.float32(0.5))
    with pytest.raises(ValueError, match="no row"):
        analyzer.result()["gyro_x"].curve
    with pytest.raises(ValueError, match="no times: give rate="):
        vn100.Analyzer(["gyro_x"]).push([1.0, 2.0])
    for gap in (-1, 2**60):
        with pytest.raises(ValueError, match="no number of samples"):
            analyzer.gap(gap)
    # rows that are all missing do not say what a count is worth, and neither do zeros
    late = vn100.Analyzer(["gyro_x"], rate=1.0)
    late.push([np.nan, np.nan])
    late.push([1e-3, -1e-3, np.nan, 2e-3])
    assert (late.samples, late.result().missing) == (3, 1), "a record begins with its first sample"
    assert late.result()["gyro_x"].curve.deviation[0] > 0
    zeros = vn100.Analyzer(["gyro_x"], rate=1.0)
    zeros.push(np.zeros(1000))
    with pytest.raises(ValueError, match="all 0 or missing, and 0.001 in row 1"):
        zeros.push([0.0, 1e-3])
    assert zeros.samples == 1000 and (zeros.result()["gyro_x"].curve.deviation == 0).all()
    for odd in (1e-300, 1e300):
        with pytest.raises(ValueError, match="scale them"):
            vn100.Analyzer(["gyro_x"], rate=1.0).push([odd, -odd])
    with pytest.raises(ValueError, match="gyro_x: inf in row 1 is not finite"):
        vn100.Analyzer(["gyro_x"], rate=1.0).push([np.nan, np.inf])
    masked = vn100.Analyzer(["gyro_x"], rate=1.0, resolution=1.0)
    masked.push(np.ma.masked_array([1.0, 2.0, 3.0], mask=[0, 1, 0]))
    assert (masked.samples, masked.result().missing) == (2, 1)


def test_rows_pushed_singly_are_those_pushed_at_once():
    random = np.random.default_rng(5)
    rows = np.column_stack([1e-3 * random.standard_normal(1500), 9.81 + 1e-2 * random.standard_normal(1500)])
    rows[:3] = 0.0
    rows[700] = np.nan
    documents = []
    for size in (1, 7, 1500):
        analyzer = vn100.Analyzer(["gyro_x", "accel_z"], rate=40.0)
        for begin in range(0, len(rows), size):
            analyzer.push(rows[begin : begin + size])
            if begin == 14:
                assert analyzer.result().samples == analyzer.samples == begin + size
        documents.append(json.dumps(analyzer.result().to_dict()))
    assert documents[0] == documents[1] == documents[2]


class Frame(dict):
    """As much of a frame as is asked for."""

    def __init__(self, columns, index):
        super().__init__(columns)
        self.index = type("Index", (), {"values": np.asarray(index)})()


def document(rows, **options):
    analyzer = vn100.Analyzer(["gyro_x", "gyro_y"], **{"rate": 100.0, "resolution": 1e-6} | options)
    analyzer.push(rows)
    return analyzer.result().to_dict()


def test_named_columns_are_taken_by_name():
    x, y = 1e-3 * np.random.default_rng(6).standard_normal((2, 3000))
    expected = document(np.column_stack([x, y]))
    frame = Frame({"note": ["text"] * 3000, "gyro_y": y, "gyro_x": x}, np.arange(3000))
    structured = np.array(list(zip(y, x, strict=True)), [("gyro_y", float), ("gyro_x", float)])
    for rows in (frame, {"gyro_y": y, "gyro_x": x}, structured):
        assert document(rows) == expected
    for module in ("pandas", "polars"):
        try:
            frames = __import__(module)
        except ImportError:
            continue
        assert document(frames.DataFrame({"gyro_y": y, "gyro_x": x})) == expected
    with pytest.raises(ValueError, match="the column gyro_x is not there among gyro_y, gyroX; gyroX may be meant"):
        document({"gyro_y": y, "gyroX": x})


def test_units_are_converted_and_say_the_quantity():
    x = np.random.default_rng(6).standard_normal(20_000)
    in_degrees = vn100.Analyzer(["wx", "up"], rate=100.0, units={"wx": "deg/s", "up": "g"})
    in_degrees.push(np.column_stack([x, x / 1000]))
    in_si = vn100.Analyzer(["a", "b"], rate=100.0, quantity={"a": "gyro", "b": "accel"})
    in_si.push(np.column_stack([np.radians(x), x * 9.80665e-3]))
    for name, other in (("wx", "a"), ("up", "b")):
        found, expected = in_degrees.result()[name], in_si.result()[other]
        assert found.unit == expected.unit and found.noise.white.status == expected.noise.white.status == "estimated"
        np.testing.assert_allclose(found.noise.white.value, expected.noise.white.value, rtol=1e-6)


@pytest.mark.parametrize("kind", ["seconds", "datetime64[ns]", "datetime64[us]", "timedelta64[ns]"])
@pytest.mark.parametrize("rate", [100.0, None])
def test_times_tell_the_rate_and_what_is_missing(kind, rate):
    random = np.random.default_rng(8)
    there = np.ones(5000, bool)
    there[1200:1600] = False
    there[random.integers(2000, 4900, 30)] = False
    seconds = np.arange(5000)[there] / 100
    stamps = seconds + 1.7e9 if kind == "seconds" else (np.round(seconds * 1e9).astype("int64") + 10**18).astype("timedelta64[ns]")
    if kind != "seconds":
        stamps = (stamps.astype("int64").view("datetime64[ns]") if "datetime" in kind else stamps).astype(kind)
    rows = 1e-3 * random.standard_normal((there.sum(), 2))
    for divided in (1, 9):
        analyzer = vn100.Analyzer(["gyro_x", "gyro_y"], rate=rate, resolution=1e-7)
        for values, times in zip(np.array_split(rows, divided), np.array_split(stamps, divided), strict=True):
            analyzer.push(Frame({"gyro_x": values[:, 0], "gyro_y": values[:, 1]}, times) if divided == 9 else values, t=None if divided == 9 else times)
        result = analyzer.result()
        assert (result.samples, result.missing) == (there.sum(), 5000 - there.sum())
        assert result.rate == pytest.approx(100.0, rel=1e-6)


def test_times_that_contradict_are_refused():
    rows = np.random.default_rng(9).standard_normal(100)
    seconds = np.arange(100) / 100
    for rate in (50.0, 98.0, 102.0, 200.0):
        with pytest.raises(ValueError, match=f"the times of the rows show 100 Hz, not {rate:g} Hz"):
            vn100.Analyzer(["a"], rate=rate).push(rows, t=seconds)
    with pytest.raises(ValueError, match="do not increase at row 4"):
        vn100.Analyzer(["a"], rate=100.0).push(rows[:5], t=[0.0, 0.01, 0.02, 0.03, 0.03])
    with pytest.raises(ValueError, match="too uneven"):
        vn100.Analyzer(["a"]).push(rows, t=np.cumsum(np.random.default_rng(1).exponential(size=100)))
    with pytest.raises(ValueError, match="other steps than 1"):
        vn100.Analyzer(["a"], rate=100.0).push(Frame({"a": rows}, np.r_[0:50, 60:110]))
    timed = vn100.Analyzer(["a"], rate=100.0)
    timed.push(rows, t=seconds)
    with pytest.raises(ValueError, match="cannot follow each other"):
        timed.push(rows)
    assert timed.samples == 100


def test_an_array_has_no_range_of_a_sensor():
    analyzer = vn100.Analyzer(["mag_x"], rate=40.0)
    analyzer.push(50 + 1e-3 * np.random.default_rng(3).standard_normal(5000))
    assert "full-range" not in [warning.code for warning in analyzer.result().warnings]


def test_missing_rows_at_the_beginning_decide_nothing():
    numbers = 1e-3 * np.random.default_rng(4).standard_normal(2000)
    expected = vn100.Analyzer(["gyro_x"], rate=40.0)
    expected.push(numbers)
    for begin in ([np.full(3000, np.nan)], [np.full(900, np.nan), [np.nan]]):
        together, apart = (vn100.Analyzer(["gyro_x"], rate=40.0) for _ in range(2))
        together.push(np.concatenate([*begin, numbers]))
        for rows in (*begin, numbers):
            apart.push(rows)
        for analyzer in (together, apart):
            assert analyzer.result().to_dict() == expected.result().to_dict()
