"""Arrays, measured as they come."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vn100
from ._arrays import numbers, whole
from ._columns import Quantity, matrix, quantities, rate_of, steps_of, times
from ._result import Result

# rows that decide what a count is worth, unless that is given
_FIRST = 1000
# binary digits of the largest magnitude of the first rows; three are left for what comes later
_DIGITS = 28

# rows with the gaps before some of them, or a gap
_Rows = tuple[NDArray[np.float64], list[tuple[int, int]]]


class Analyzer:
    """Accumulates rows of numbers; results at any time, in bounded memory.

    ``channels`` are names; ``gyro_...`` are rad/s, ``accel_...`` m/s², ``mag_...``
    gauss, others neutral series without a noise model of a sensor. A name that only
    resembles one of these (``GyroX``, ``wx``) is an error. ``units`` are the units of
    channels by name, as in ``{"wx": "deg/s"}``: they are converted, and say the quantity;
    ``quantity`` says it by itself: ``"gyro"``, ``"accel"``, ``"mag"`` or ``"value"``, of
    all channels or by name. ``rate`` is in hertz; it may be left out if the rows have times.

    ``resolution`` is what an integer count is worth, of all channels or of each, in the
    unit of the channel: give that of your sensor, and sums are exact. By default the first
    1000 rows decide, however they are divided: a power of two, 2^-28 of the largest
    magnitude, with room for eight times that; the deviation is then within 1e-6 of that of
    the floats if the noise is more than a millionth of that magnitude. Of values with a
    large constant part, such as the frequency of a clock, subtract that first.

    ``compensated`` says whether a filter has removed the bias of the angular rates
    (``True`` or ``"yes"``, ``False`` or ``"no"``): with ``True``, B, K and R of a
    gyroscope are not measurable. ``taus`` are the averaging times of the curves:
    ``"octave"``, or with ``estimator="full"``, which keeps all samples, ``"decade"`` or a list of
    seconds. The noise model takes the octaves in any case.

    Raises :exc:`ValueError` and :exc:`TypeError` for options that do not exist.
    """

    def __init__(
        self,
        channels: Sequence[str],
        *,
        rate: float | None = None,
        units: Mapping[str, str] | None = None,
        quantity: Quantity | Mapping[str, Quantity] | None = None,
        resolution: float | Sequence[float] | None = None,
        estimator: str = "strided",
        deviation: str = "allan",
        confidence: float = 0.95,
        compensated: bool | Literal["yes", "no"] | None = None,
        taus: Literal["octave", "decade"] | Sequence[float] | None = None,
    ) -> None:
        names = [channels] if isinstance(channels, str) else list(channels)
        found, self._factors = quantities(names, units or {}, quantity)
        self._names = names
        self._steps: list[float] | None = None
        if resolution is not None:
            given = numbers(resolution, "resolutions")
            steps = np.full(len(names), given) if given.ndim == 0 else given.ravel()
            if steps.shape != (len(names),):
                raise ValueError("resolution: one number above 0 for each channel")
            self._steps = [float(step) for step in steps * self._factors]
        if rate is not None and (isinstance(rate, bool) or not isinstance(rate, Real)):
            raise TypeError(f"rate: {rate!r} is no number of hertz")
        self._rate: float | None = None if rate is None else float(rate)
        times = taus if taus is None or isinstance(taus, str) else [float(tau) for tau in numbers(taus, "taus").ravel()]
        self._options = (estimator, deviation, confidence, compensated, times)
        self._channels: list[tuple[str, str]] = [*zip(names, found, strict=True)]
        # the first rows; nothing once they have decided
        self._pending: list[_Rows | int | None] = []
        self._sums: _vn100.Sums | None = None
        # channels that were 0 in all of the first rows
        self._zero: NDArray[np.bool_] = np.zeros(len(names), bool)
        # of the last row, if rows have times
        self._last: float | None = None
        self._are_timed: bool | None = None
        # one thread may push while others ask for results
        self._lock = threading.Lock()
        # of all rows so far
        self._result: Result | None = None
        # options are refused at once
        self._counting(self._steps or [1.0] * len(names), 1.0 if self._rate is None else self._rate)

    def _counting(self, steps: list[float], rate: float) -> _vn100.Sums:
        return _vn100.Sums(self._channels, rate, steps, *self._options)

    def __repr__(self) -> str:
        rate = "a rate that the times will show" if self._rate is None else f"{self._rate:g} Hz"
        return f"<vn100.Analyzer: {self.samples} samples at {rate}, {len(self._names)} channels>"

    def push(self, rows: ArrayLike | Any, *, t: ArrayLike | None = None) -> None:
        """Adds rows in time order: shape ``(n, channels)``, or ``(n,)`` for one channel.

        Rows with named columns (a frame of pandas or polars, a mapping of columns, a
        structured array) are taken by name, in any order; others by position. ``t`` are the
        times of the rows, shape ``(n,)``: seconds, ``datetime64`` or ``timedelta64``; by
        default an index of times. Times give the rate, if none was given, and the rows that
        are missing between others.

        NaN is a missing number, as is what a masked array masks; a row of NaN is a missing
        sample between those that are there: it counts once a row follows, and not before
        the first of the record. Raises :exc:`ValueError` for other shapes, for columns that
        are not there, for times that do not increase or contradict ``rate`` by more than
        1 %, and for numbers beyond 32 bits of the resolution, :exc:`TypeError` for what is
        no number; then none of the rows is taken. Ctrl-C leaves the first of many rows
        taken: :attr:`samples` gives their number. Other threads may push and ask for
        results meanwhile.
        """
        values = matrix(rows, self._names) * self._factors
        seconds = times(rows, t, len(values))
        if len(values) == 0:
            return
        with self._lock:
            if self._are_timed not in (None, seconds is not None):
                raise ValueError("rows with times and rows without times cannot follow each other")
            rate = self._rate
            gaps: list[tuple[int, int]] = []
            if seconds is not None:
                rate, gaps = self._gaps(steps_of(seconds, self._last))
            if rate is None:
                raise ValueError("the rows have no times: give rate=, in hertz")
            infinite = np.argwhere(np.isinf(values))
            if len(infinite):
                row, column = infinite[0]
                raise ValueError(f"{self._names[column]}: {values[row, column]} in row {row} is not finite: give NaN for a missing number")
            self._take((values, gaps), rate)
            self._result = None
            self._rate, self._are_timed = rate, seconds is not None
            if seconds is not None:
                self._last = float(seconds[-1])

    def _gaps(self, steps: NDArray[np.float64]) -> tuple[float, list[tuple[int, int]]]:
        """The rate, and the rows before which others are missing."""
        if len(steps) == 0 and self._rate is not None:
            return self._rate, []
        measured = rate_of(steps) if self._rate is None or len(steps) > 3 else self._rate
        rate = measured if self._rate is None else self._rate
        if abs(measured / rate - 1) > 0.01:
            raise ValueError(f"rate: the times of the rows show {measured:.6g} Hz, not {rate:g} Hz")
        counts = np.round(steps * rate).astype(np.int64)
        first = 1 if self._last is None else 0
        places = np.flatnonzero(counts > 1)
        return rate, [(int(place) + first, int(counts[place]) - 1) for place in places]

    def _take(self, rows: _Rows, rate: float) -> None:
        values, gaps = rows
        if self._sums is not None:
            self._refuse_what_zeros_do_not_tell(values)
            self._sums.push(values, gaps)
            return
        if np.isnan(values).all():
            # such rows decide nothing, and are not kept
            self._pending.append(len(values) + sum(missing for _, missing in gaps))
            return
        pending = [*self._pending, (values.copy(), gaps)]
        known = sum(int(_has_number(item[0]).sum()) for item in pending if isinstance(item, tuple))
        if self._steps is not None or known >= _FIRST:
            self._sums, self._pending = self._started(pending, rate), []
        else:
            # numbers that cannot be counted are refused with the rows that have them
            self._first_steps(pending)
            self._pending = pending

    def _first_steps(self, pending: list[_Rows | int | None]) -> tuple[list[float], NDArray[np.bool_]]:
        """What a count is worth, and which channels are zero so far."""
        most = np.zeros(len(self._names))
        seen = 0
        for values in (item[0] for item in pending if isinstance(item, tuple)):
            first = values[_has_number(values)][: _FIRST - seen]
            most = np.fmax(most, np.nanmax(np.abs(np.nan_to_num(first)), axis=0, initial=0.0))
            seen += len(first)
        for name, largest in zip(self._names, most, strict=True):
            if largest and not 1e-290 < largest < 1e290:
                raise ValueError(f"{name}: numbers up to {largest:e} leave the range of floats when they are summed or divided: scale them")
        exponents = np.floor(np.log2(np.where(most > 0, most, 1.0))) + 1 - _DIGITS
        return [float(step) for step in np.where(most > 0, 2.0**exponents, 1.0)], most == 0

    def _started(self, pending: list[_Rows | int | None], rate: float) -> _vn100.Sums:
        steps, zero = (self._steps, self._zero) if self._steps is not None else self._first_steps(pending)
        sums = self._counting(steps, rate)
        for item in pending:
            if isinstance(item, tuple):
                beyond = np.argwhere(zero & (np.nan_to_num(item[0]) != 0))
                self._refuse_zeros(item[0], beyond)
                sums.push(*item)
            else:
                sums.gap(item)
        self._zero = zero
        return sums

    def _refuse_what_zeros_do_not_tell(self, values: NDArray[np.float64]) -> None:
        if self._zero.any():
            self._refuse_zeros(values, np.argwhere(self._zero & (np.nan_to_num(values) != 0)))

    def _refuse_zeros(self, values: NDArray[np.float64], beyond: NDArray[np.intp]) -> None:
        if len(beyond):
            row, column = beyond[0]
            raise ValueError(
                f"{self._names[column]}: the first {_FIRST} rows were all 0 or missing, and {values[row, column]} in row {row} "
                "does not follow from them: give resolution"
            )

    def gap(self, missing: int | None) -> None:
        """So many rows are missing here, as if they were NaN; ``None`` for an unknown
        number, across which no window reaches."""
        known = None if missing is None else whole(missing, "missing")
        with self._lock:
            self._result = None
            if self._sums is None:
                self._pending.append(known)
            else:
                self._sums.gap(known)
            # the time of the next row says nothing of a gap that was told
            self._last = None

    @property
    def samples(self) -> int:
        """Rows so far, missing ones not counted."""
        with self._lock:
            if self._sums is not None:
                return self._sums.samples
            arrays = (item[0] for item in self._pending if isinstance(item, tuple))
            return sum(int(_has_number(values).sum()) for values in arrays)

    def result(self) -> Result:
        """Everything, as of a capture; the same object until rows follow. Raises
        :exc:`ValueError` before the first row."""
        if self.samples == 0:
            raise ValueError("no row was pushed yet")
        with self._lock:
            if self._result is None:
                # the first rows decide later: until then they are counted anew
                sums = self._sums or self._started(self._pending, self._rate or 1.0)
                self._result = Result(sums.result())
            return self._result


def _has_number(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of each row, whether any number is there."""
    return np.asarray(np.any(~np.isnan(values), axis=1), bool)
