"""The drop-ins beside allantools."""

import math
import signal
import subprocess
import sys
import time
from fractions import Fraction

import allantools
import numpy as np
import pytest
import vn100
from hypothesis import given, settings
from hypothesis import strategies as st

NAMES = ["oadev", "adev", "hdev", "ohdev", "mdev", "totdev"]
FLOATS = NAMES[4:]


def compared(name, data, tolerance, **options):
    ours, theirs = getattr(vn100, name)(data, **options), getattr(allantools, name)(data, **options)
    for one, other in zip(ours, theirs, strict=True):
        assert one.shape == other.shape and one.dtype == np.float64
        np.testing.assert_allclose(one, other, rtol=tolerance, atol=0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("taus", [None, "octave", "decade", "log10", "all", np.arange(1, 350) / 40, [0.1, 0.26, 1.0, 3.31, 1e9], 0.5])
@pytest.mark.parametrize("data_type", ["phase", "freq"])
def test_whole_numbers_give_the_same_four_results(name, taus, data_type, noise):
    data = np.cumsum(noise) if data_type == "phase" else noise
    theirs = np.array([taus]) if isinstance(taus, float) else taus
    ours = getattr(vn100, name)(data.astype(float), rate=40.0, data_type=data_type, taus=taus)
    for one, other in zip(ours, getattr(allantools, name)(data.astype(float), 40.0, data_type, theirs), strict=True):
        assert one.shape == other.shape and one.dtype == np.float64
        # both are rounded where sums are floats
        np.testing.assert_allclose(one, other, rtol=1e-9 if name in FLOATS else 1e-12, atol=0)


def exact(phase, m, order):
    """The deviation of whole phases in whole numbers, but for one root."""
    p = [phase[lag * m : len(phase) - (order - lag) * m] for lag in range(order + 1)]
    z = p[2] - 2 * p[1] + p[0] if order == 2 else p[3] - 3 * p[2] + 3 * p[1] - p[0]
    high, low = z >> 20, z & 0xFFFFF
    squares = (int((high * high).sum()) << 40) + (int((high * low).sum()) << 21) + int((low * low).sum())
    return math.sqrt(Fraction(squares, (2 if order == 2 else 6) * m * m * len(z)))


@pytest.mark.parametrize(("name", "order"), [("oadev", 2), ("ohdev", 3)])
@pytest.mark.parametrize("offset", [0, 123_456])
def test_a_million_whole_numbers_give_the_exact_deviation(name, order, offset):
    # allantools rounds a float sum of rates: at ten million samples it is off by 1.9e-11, and this by 1.1e-14
    counts = np.round(1000 * np.random.default_rng(1).standard_normal(1_000_000)).astype(np.int64) + offset
    phase = np.concatenate([[0], np.cumsum(counts)])
    for data, data_type in [(counts, "freq"), (phase, "phase")]:
        taus, found, _, _ = getattr(vn100, name)(data, rate=1.0, data_type=data_type)
        expected = [exact(phase, int(m), order) for m in taus]
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("data_type", ["phase", "freq"])
def test_floats_do_within_a_millionth(name, data_type):
    random = np.random.default_rng(3)
    rates = 9.81 + 1e-3 * random.standard_normal(20_000)
    data = np.cumsum(rates - 9.81) / 40 if data_type == "phase" else rates
    compared(name, data, 1e-6, rate=40.0, data_type=data_type)


def test_the_suite_of_nist_is_met():
    # NIST SP 1065, table 31: the deviations of 1000 numbers of a generator, at m = 1, 10, 100
    numbers, n = [], 1234567890
    for _ in range(1000):
        numbers.append(n / 2147483647)
        n = 16807 * n % 2147483647
    expected = {
        "adev": [2.922319e-01, 9.965736e-02, 3.897804e-02],
        "oadev": [2.922319e-01, 9.159953e-02, 3.241343e-02],
        "hdev": [2.943883e-01, 1.052754e-01, 3.910860e-02],
        "ohdev": [2.943883e-01, 9.581083e-02, 3.237638e-02],
        "mdev": [2.922319e-01, 6.172376e-02, 2.170921e-02],
        "totdev": [2.922319e-01, 9.134743e-02, 3.406530e-02],
    }
    for name, deviations in expected.items():
        found = getattr(vn100, name)(numbers, rate=1.0, data_type="freq", taus=[1, 10, 100])
        np.testing.assert_allclose(found[1], deviations, rtol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-(10**6), 10**6), min_size=4, max_size=200), st.sampled_from(["oadev", "adev", *FLOATS]))
def test_any_whole_numbers_agree(values, name):
    data = np.array(values, float)
    ours, theirs = getattr(vn100, name)(data, data_type="freq"), getattr(allantools, name)(data, data_type="freq")
    np.testing.assert_allclose(ours[1], theirs[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(ours[3], theirs[3])


BASE = np.round(1000 * np.random.default_rng(2).standard_normal(100))


@pytest.mark.parametrize(
    "data",
    [
        np.column_stack([BASE, BASE])[:, 1],
        np.flip(np.flip(BASE).copy()),
        np.asfortranarray(BASE[:, None]).ravel(),
        BASE.astype("f4"),
        BASE.astype("i2"),
        BASE.astype(">f8"),
        BASE.astype(">i4"),
        BASE.astype("O"),
        np.frombuffer(BASE.tobytes()),
        memoryview(BASE),
        BASE.tolist(),
        tuple(BASE),
        np.ma.masked_array(BASE, mask=False),
    ],
    ids="strided reversed fortran f4 i2 big-f8 big-i4 objects read-only memoryview list tuple masked".split(),
)
def test_any_array_of_the_same_numbers_gives_the_same(data):
    for ours, expected in zip(vn100.oadev(data, data_type="freq"), vn100.oadev(BASE, data_type="freq"), strict=True):
        np.testing.assert_array_equal(ours, expected)
    analyzer, other = (vn100.Analyzer(["gyro_x"], rate=1.0, resolution=1.0) for _ in range(2))
    analyzer.push(data)
    other.push(BASE)
    assert analyzer.result().to_dict() == other.result().to_dict()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"data": [1.0, np.nan, 2.0, 1.0]}, ValueError, "NaN"),
        ({"data": [1.0, np.inf, 2.0, 1.0]}, ValueError, "infinite"),
        ({"data": np.ma.masked_array([1.0, 2.0, 3.0, 4.0], mask=[0, 1, 0, 0])}, ValueError, "gap"),
        ({"data": [1.0, 2.0]}, ValueError, "too few"),
        ({"data": [1.0]}, ValueError, "too few"),
        ({"data": []}, ValueError, "too few"),
        ({"data": [np.nan] * 9}, ValueError, "too few"),
        ({"data": [[1.0, 2.0]]}, ValueError, "2 dimensions"),
        ({"data": 3.0}, ValueError, "0 dimensions"),
        ({"data": [[1.0], [1.0, 2.0]]}, ValueError, "different lengths"),
        ({"data": None}, TypeError, "no real numbers"),
        ({"data": "abc"}, TypeError, "no real numbers"),
        ({"data": ["a", "b", "c", "d"]}, TypeError, "no real numbers"),
        ({"data": [1, "x", 2, 3]}, TypeError, "no real numbers"),
        ({"data": {}}, TypeError, "no real numbers"),
        ({"data": np.ones(9) * 1j}, TypeError, "complex128"),
        ({"data": np.array(["2020-01-01"] * 9, "M8[D]")}, TypeError, "datetime64"),
        ({"data": [1e300, -1e300, 1e300, -1e300]}, ValueError, "scale them"),
        ({"data": [1e-300, 2e-300, 4e-300, -1e-300]}, ValueError, "scale them"),
        ({"rate": 0.0}, ValueError, "rate of 0.0 Hz"),
        ({"rate": -40}, ValueError, "rate of -40 Hz"),
        ({"rate": np.nan}, ValueError, "rate of nan Hz"),
        ({"rate": np.inf}, ValueError, "rate of inf Hz"),
        ({"rate": "40"}, TypeError, "'40' is no number"),
        ({"rate": True}, TypeError, "True is no number"),
        ({"rate": None}, TypeError, "None is no number"),
        ({"data_type": "frequency"}, ValueError, "neither 'phase' nor 'freq'"),
        ({"taus": "octaves"}, ValueError, "neither 'octave'"),
        ({"taus": [-1.0, 0.0]}, ValueError, "none of the taus"),
        ({"taus": [np.nan]}, ValueError, "none of the taus"),
        ({"taus": [1e30]}, ValueError, "none of the taus"),
        ({"taus": ["a"]}, TypeError, "no real numbers"),
    ],
)
def test_what_cannot_be_given_is_said(options, error, words):
    for name in NAMES:
        with pytest.raises(error, match=words):
            getattr(vn100, name)(**{"data": BASE, "data_type": "freq"} | options)


def test_missing_values_at_the_ends_are_none_of_the_record():
    ends = vn100.oadev([np.nan, 1.0, 4.0, 2.0, np.nan], data_type="freq")
    np.testing.assert_array_equal(ends[1], vn100.oadev([1.0, 4.0, 2.0], data_type="freq")[1])
    constant = vn100.oadev(np.full(50, 9.81), data_type="freq")
    assert (constant[1] == 0).all() and len(constant[0]) == 5


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_ends_a_long_calculation():
    script = """
import numpy as np, vn100
data, taus = np.ones(4_000_000), np.arange(1.0, 40_000.0)
print('ready', flush=True)
try:
    vn100.oadev(data, taus=taus)
except KeyboardInterrupt:
    print('interrupted')
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    assert process.stdout.readline().strip() == b"ready"
    # the interpreter has prepared what is calculated
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    try:
        assert process.communicate(timeout=20)[0].strip() == b"interrupted"
    finally:
        process.kill()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(20, 400), st.floats(0, 0.3))
def test_phase_with_gaps_is_that_of_allantools(seed, length, share):
    random = np.random.default_rng(seed)
    data = np.cumsum(random.standard_normal(length))
    data[random.random(length) < share] = np.nan
    theirs = allantools.gradev(data, 10.0, "phase", "octave")
    ours = vn100.gradev(data, 10.0, "phase", "octave")
    for place in (0, 1, 3):
        np.testing.assert_allclose(ours[place], theirs[place], rtol=1e-9)


def test_rates_after_a_gap_count_as_those_before():
    random = np.random.default_rng(4)
    data = random.standard_normal(3000)
    data[1000:1040] = np.nan
    taus, found, _, ns = vn100.gradev(data, 10.0, "freq", [0.1, 1.6, 12.8])
    parts = [vn100.oadev(part, 10.0, "freq", taus) for part in (data[:1000], data[1040:])]
    windows = np.array([part[3] for part in parts])
    squares = np.array([part[1] for part in parts]) ** 2
    np.testing.assert_allclose(ns, windows.sum(axis=0))
    np.testing.assert_allclose(found, np.sqrt((squares * windows).sum(axis=0) / ns), rtol=1e-9)


@pytest.mark.parametrize("data_type", ["phase", "freq"])
def test_without_a_gap_it_is_the_overlapping_deviation(data_type):
    data = np.random.default_rng(5).standard_normal(500)
    for one, other in zip(vn100.gradev(data, 4.0, data_type), vn100.oadev(data, 4.0, data_type), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)
    with pytest.raises(ValueError, match="too few"):
        vn100.gradev(np.full(10, np.nan), 1.0, data_type="phase")
