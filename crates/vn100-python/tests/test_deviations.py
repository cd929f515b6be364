"""The drop-ins beside allantools."""

import allantools
import numpy as np
import pytest
import vn100
from hypothesis import given, settings
from hypothesis import strategies as st

NAMES = ["oadev", "adev", "hdev", "ohdev"]


def compared(name, data, tolerance, **options):
    ours, theirs = getattr(vn100, name)(data, **options), getattr(allantools, name)(data, **options)
    for one, other in zip(ours, theirs, strict=True):
        assert one.shape == other.shape and one.dtype == np.float64
        np.testing.assert_allclose(one, other, rtol=tolerance, atol=0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("taus", [None, "octave", "decade", "all", [0.1, 0.25, 1.0, 3.3, 1e9]])
@pytest.mark.parametrize("data_type", ["phase", "freq"])
def test_whole_numbers_give_the_same_four_results(name, taus, data_type, noise):
    data = (np.cumsum(noise) if data_type == "phase" else noise)[: 700 if taus == "all" else None]
    compared(name, data.astype(float), 1e-12, rate=40.0, data_type=data_type, taus=taus)


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
    }
    for name, deviations in expected.items():
        found = getattr(vn100, name)(numbers, rate=1.0, data_type="freq", taus=[1, 10, 100])
        np.testing.assert_allclose(found[1], deviations, rtol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-(10**6), 10**6), min_size=4, max_size=200), st.sampled_from(NAMES[:2]))
def test_any_whole_numbers_agree(values, name):
    data = np.array(values, float)
    ours, theirs = getattr(vn100, name)(data, data_type="freq"), getattr(allantools, name)(data, data_type="freq")
    np.testing.assert_allclose(ours[1], theirs[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(ours[3], theirs[3])


def test_what_cannot_be_given_is_said():
    with pytest.raises(ValueError, match="NaN"):
        vn100.oadev([1.0, np.nan, 2.0, 1.0], data_type="freq")
    with pytest.raises(ValueError, match="neither"):
        vn100.oadev([1.0, 2.0, 3.0], data_type="frequency")
    with pytest.raises(ValueError, match="too few"):
        vn100.oadev([1.0, 2.0])
    with pytest.raises(ValueError, match="dimensions"):
        vn100.oadev([[1.0, 2.0]])
    # missing values at the ends are none of the record, as there
    ends = vn100.oadev([np.nan, 1.0, 4.0, 2.0, np.nan], data_type="freq")
    np.testing.assert_array_equal(ends[1], vn100.oadev([1.0, 4.0, 2.0], data_type="freq")[1])
