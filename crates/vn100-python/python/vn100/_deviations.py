"""The deviations of whole arrays, called as those of allantools."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vn100
from ._arrays import numbers

Taus: TypeAlias = Literal["octave", "decade", "log10", "all"] | float | Sequence[float] | NDArray[np.float64] | None
Four: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def oadev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Overlapping Allan deviation (NIST SP 1065, eq. 11).

    ``data`` has the shape ``(n,)``: phase in seconds, or with ``data_type="freq"``
    rates, such as those of a gyroscope. ``rate`` is in hertz. ``taus`` are in seconds,
    taken to whole samples, or ``"octave"``, ``"decade"``, ``"log10"`` (ten in a decade) or
    ``"all"``; those with fewer than two windows are left out.

    Returns ``(taus, deviations, errors, ns)`` as allantools does, float64 arrays of one
    shape: averaging times in seconds; deviations, within 1e-6 of those of allantools;
    ``errors``, the deviation over the root of ``ns``; and ``ns``, the number of windows.
    For whole numbers the deviation is within 1e-12 of the exact one, where allantools
    rounds a float sum of the rates (1.9e-11 at ten million).

    ``errors`` are those of allantools, and too small: overlapping windows are not
    independent. :class:`vn100.Analyzer` gives the interval of each octave by its
    degrees of freedom, in :attr:`vn100.Curve.lower` and :attr:`vn100.Curve.upper`.

    Raises :exc:`ValueError` for a NaN or an infinite number inside, for fewer than two
    windows, and for options that do not exist; :exc:`TypeError` for what is no number.
    """
    return _four(data, rate, data_type, taus, hadamard=False, overlapping=True)


def adev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Allan deviation of adjacent windows (NIST SP 1065, eq. 10); as :func:`oadev`."""
    return _four(data, rate, data_type, taus, hadamard=False, overlapping=False)


def ohdev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Overlapping Hadamard deviation (NIST SP 1065, eq. 20), which no linear drift of the
    rate changes; as :func:`oadev`."""
    return _four(data, rate, data_type, taus, hadamard=True, overlapping=True)


def hdev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Hadamard deviation of adjacent windows (NIST SP 1065, eq. 18); as :func:`oadev`."""
    return _four(data, rate, data_type, taus, hadamard=True, overlapping=False)


def mdev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Modified Allan deviation (NIST SP 1065, eq. 15), which tells white from flicker
    phase noise; as :func:`oadev`, in floats as allantools."""
    hz, values, factors = _prepared(data, rate, data_type, taus)
    phase = _phase(values, data_type)
    # longer windows than three in the record have no term
    factors = factors[3 * factors <= len(phase)]
    squares, windows = [], []
    for m in factors:
        sums = np.concatenate([[0.0], np.cumsum(phase[2 * m :] - 2 * phase[m:-m] + phase[: -2 * m])])
        terms = (sums[m:] - sums[:-m]) / m
        squares.append(np.mean(terms * terms))
        windows.append(len(terms))
    return _finished(hz, len(values), data_type, factors, np.sqrt(np.array(squares) / 2) / factors, windows)


def totdev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Total deviation (NIST SP 1065, eq. 25): the record is continued at both ends by
    its reflections, for more confidence at long averaging times. As :func:`oadev`, in floats
    as allantools, without a correction of the bias."""
    hz, values, factors = _prepared(data, rate, data_type, taus)
    phase = _phase(values, data_type)
    inner = max(len(phase) - 2, 0)
    whole = np.concatenate([2 * phase[:1] - phase[-2:0:-1], phase, 2 * phase[-1:] - phase[-2:0:-1]])
    squares = []
    for m in factors:
        middle, before, after = (whole[inner + 1 + shift :][:inner] for shift in (0, -m, m))
        squares.append(np.sum((before - 2 * middle + after) ** 2) / max(inner, 1))
    return _finished(hz, len(values), data_type, factors, np.sqrt(np.array(squares) / 2) / factors, [inner] * len(factors))


def gradev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Overlapping Allan deviation of a record with gaps (NaN), of the windows in which nothing
    is missing; as :func:`oadev`, in floats as allantools. There rates end at their first gap, and
    ``errors`` are bounds by a type of noise; here rates after a gap count too."""
    hz, values, factors = _prepared(data, rate, data_type, taus)
    missing = np.isnan(values)
    mean = float(np.mean(values[~missing])) if not missing.all() else 0.0
    phase = _phase(np.where(missing, mean, values), data_type)
    lost = np.zeros(len(phase), np.int64)
    if data_type == "phase":
        phase = np.where(missing, np.nan, phase)
    elif len(phase):
        lost[1:] = np.cumsum(missing)
    squares, windows = [], []
    for m in factors:
        terms = (phase[2 * m :] - 2 * phase[m:-m] + phase[: -2 * m])[lost[2 * m :] == lost[: -2 * m]]
        terms = terms[~np.isnan(terms)]
        squares.append(np.sum(terms * terms) / max(len(terms), 1))
        windows.append(len(terms))
    return _finished(hz, len(values), data_type, factors, np.sqrt(np.array(squares) / 2) / factors, windows)


def _phase(values: NDArray[np.float64], data_type: str) -> NDArray[np.float64]:
    """In samples, of rates without their mean."""
    if not np.isfinite(values).all():
        raise ValueError("the data have a gap (NaN), or an infinite value: gradev and Analyzer take gaps")
    largest = float(np.abs(values).max(initial=0.0))
    if largest and not 1e-150 < largest < 1e150:
        raise ValueError("the data leave the range of floats when they are summed or divided: scale them")
    if data_type == "phase":
        return values
    return np.concatenate([[0.0], np.cumsum(values - np.mean(values))]) if len(values) else values


def _four(
    data: ArrayLike, rate: float, data_type: str, taus: Taus, *, hadamard: bool, overlapping: bool
) -> Four:
    hz, values, factors = _prepared(data, rate, data_type, taus)
    work = np.empty(len(values) + 1)
    found, windows = _vn100.deviations(values, work, data_type == "phase", hadamard, overlapping, factors.tolist())
    return _finished(hz, len(values), data_type, factors, np.array(found, np.float64), windows)


def _prepared(
    data: ArrayLike, rate: float, data_type: str, taus: Taus
) -> tuple[float, NDArray[np.float64], NDArray[np.int64]]:
    """The rate in hertz, the values and the averaging factors."""
    if data_type not in ("phase", "freq"):
        raise ValueError(f"data_type {data_type!r} is neither 'phase' nor 'freq'")
    hz = _rate(rate)
    values = numbers(data, "data")
    if values.ndim != 1:
        raise ValueError(f"data have {values.ndim} dimensions, not one")
    is_phase = data_type == "phase"
    if not is_phase:
        values = _trimmed(values)
    return hz, values, _factors(len(values) + (not is_phase), hz, taus)


def _finished(
    hz: float, count: int, data_type: str, factors: NDArray[np.int64], found: NDArray[np.float64], windows: list[int]
) -> Four:
    ns = np.array(windows, np.float64)
    kept = ns > 1
    if not kept.any():
        raise ValueError(f"{count} values are too few for two windows at any of the averaging times")
    deviations = found[kept] * (hz if data_type == "phase" else 1.0)
    return factors[kept] / hz, deviations, deviations / np.sqrt(ns[kept]), ns[kept]


def _rate(rate: float) -> float:
    if isinstance(rate, bool) or not isinstance(rate, Real):
        raise TypeError(f"the rate {rate!r} is no number of hertz")
    hz = float(rate)
    if not 1e-100 < hz < 1e100:
        raise ValueError(f"a rate of {rate} Hz does not exist")
    return hz


def _trimmed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Without missing values at the ends, as allantools has it."""
    if len(values) == 0 or not (np.isnan(values[0]) or np.isnan(values[-1])):
        return values
    present = np.flatnonzero(~np.isnan(values))
    return values[present[0] : present[-1] + 1] if len(present) else values[:0]


def _factors(points: int, rate: float, taus: Taus) -> NDArray[np.int64]:
    """The averaging factors of phase with so many points."""
    if points < 2:
        return np.array([], np.int64)
    if taus is None or (isinstance(taus, (list, tuple)) and len(taus) == 0):
        taus = "octave"
    if isinstance(taus, str):
        if taus == "octave":
            m = 2.0 ** np.arange(int(np.floor(np.log2(points))) + 1)
        elif taus == "decade":
            decades = 10.0 ** np.arange(int(np.floor(np.log10(points))) + 1)
            m = (decades[:, None] * np.array([1.0, 2.0, 4.0])).ravel()
        elif taus == "log10":
            m = np.round(np.logspace(0, np.log10(points), int(10 * np.log10(points))))
        elif taus == "all":
            m = np.arange(1.0, points)
        else:
            raise ValueError(f"taus {taus!r} is neither 'octave', 'decade', 'log10', 'all' nor a list of seconds")
    else:
        m = np.round(np.atleast_1d(numbers(taus, "taus")).ravel() * rate)
    kept = m[(m > 0) & (m < points)]
    if len(kept) == 0:
        raise ValueError(f"none of the taus is between {1 / rate:g} s, the sample interval, and the length of the data")
    return np.unique(kept.astype(np.int64))
