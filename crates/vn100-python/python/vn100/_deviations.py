"""The deviations of whole arrays, called as those of allantools."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vn100

Taus: TypeAlias = Literal["octave", "decade", "all"] | Sequence[float] | NDArray[np.float64] | None
Four: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def oadev(
    data: ArrayLike, rate: float = 1.0, data_type: Literal["phase", "freq"] = "phase", taus: Taus = None
) -> Four:
    """Overlapping Allan deviation (NIST SP 1065, eq. 11).

    ``data`` has the shape ``(n,)``: phase in seconds, or with ``data_type="freq"``
    rates, such as those of a gyroscope. ``rate`` is in hertz, ``taus`` in seconds:
    ``"octave"``, ``"decade"``, ``"all"`` or a list.

    Returns ``(taus, deviations, errors, ns)``, arrays of one shape: those of
    allantools, within 1e-6, and exact for integers. As there, ``errors`` is the
    deviation over the root of ``ns``; overlapping windows are not independent, so
    that :class:`vn100.Analyzer` has the honest intervals.
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


def _four(
    data: ArrayLike, rate: float, data_type: str, taus: Taus, *, hadamard: bool, overlapping: bool
) -> Four:
    if not rate > 0:
        raise ValueError(f"a rate of {rate} Hz does not exist")
    if data_type not in ("phase", "freq"):
        raise ValueError(f"data_type {data_type!r} is neither 'phase' nor 'freq'")
    values = np.ascontiguousarray(data, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"data have {values.ndim} dimensions, not one")
    is_phase = data_type == "phase"
    if not is_phase:
        values = _trimmed(values)
    factors = _factors(len(values) + (not is_phase), float(rate), taus)
    deviations, windows = _vn100.deviations(values, is_phase, hadamard, overlapping, factors.tolist())
    ns = np.array(windows, np.float64)
    found = np.array(deviations, np.float64) * (rate if is_phase else 1.0)
    kept = ns > 1
    if not kept.any():
        raise ValueError(f"{len(values)} values are too few for two windows at any of the averaging times")
    errors = found[kept] / np.sqrt(ns[kept])
    return factors[kept] / float(rate), found[kept], errors, ns[kept]


def _trimmed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Without missing values at the ends, as allantools has it."""
    present = np.flatnonzero(~np.isnan(values))
    return values[present[0] : present[-1] + 1] if len(present) else values[:0]


def _factors(points: int, rate: float, taus: Taus) -> NDArray[np.int64]:
    """The averaging factors of phase with so many points."""
    if points == 0:
        return np.array([], np.int64)
    if taus is None or (not isinstance(taus, (str, np.ndarray)) and len(taus) == 0):
        taus = "octave"
    if isinstance(taus, str):
        if taus == "octave":
            wanted = 2.0 ** np.arange(int(np.floor(np.log2(points))) + 1)
        elif taus == "decade":
            decades = 10.0 ** np.arange(int(np.floor(np.log10(points))) + 1)
            wanted = (decades[:, None] * np.array([1.0, 2.0, 4.0])).ravel()
        elif taus == "all":
            wanted = np.arange(1.0, points + 1.0)
        else:
            raise ValueError(f"taus {taus!r} is none of 'octave', 'decade', 'all', and no list")
        m = wanted[wanted < points].astype(np.int64)
    else:
        seconds = np.asarray(taus, np.float64)
        seconds = seconds[(seconds > 0) & (seconds < points / rate)]
        m = np.floor(seconds * rate).astype(np.int64)
    return np.unique(m[m > 0])
