"""Arrays, measured as they come."""

from __future__ import annotations

import json
import threading
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _vn100
from ._arrays import numbers, whole
from ._result import Channel, Curve, Noise, Result


class Analyzer:
    """Accumulates rows of numbers; results at any time, in bounded memory.

    ``channels`` are names; ``gyro_...`` are rad/s, ``accel_...`` m/s², ``mag_...``
    gauss, others neutral series without a noise model of a sensor. ``rate`` is in
    hertz. ``resolution`` is what an integer count is worth, of all channels or of
    each: give that of your sensor, and sums are exact. By default the first rows
    decide: a power of two, 2^-28 of the largest magnitude, with room for eight times
    that; the deviation is then within 1e-6 of that of the floats where the noise is more
    than a millionth of that magnitude. Of values with a large constant part, such as the
    frequency of a clock, subtract that first.

    ``compensated`` says whether a filter has removed the bias of the angular rates
    (``True`` or ``"yes"``, ``False`` or ``"no"``): with ``True``, B, K and R of a
    gyroscope are not measurable.
    """

    def __init__(
        self,
        channels: Sequence[str],
        *,
        rate: float,
        resolution: float | Sequence[float] | None = None,
        estimator: str = "strided",
        deviation: str = "allan",
        confidence: float = 0.95,
        compensated: bool | Literal["yes", "no"] | None = None,
    ) -> None:
        names = [channels] if isinstance(channels, str) else list(channels)
        steps: list[float] | None
        if resolution is None:
            steps = None
        else:
            given = numbers(resolution, "resolutions")
            steps = [float(step) for step in (np.full(len(names), given) if given.ndim == 0 else given.ravel())]
        self._sums = _vn100.Sums(names, rate, steps, estimator, deviation, confidence, compensated)
        self._names = names
        self._rate = rate
        # one thread may push while others ask for results
        self._lock = threading.Lock()
        # of all rows so far
        self._result: Result | None = None

    def __repr__(self) -> str:
        return f"<vn100.Analyzer: {self.samples} samples at {self._rate:g} Hz, {len(self._names)} channels>"

    def push(self, rows: ArrayLike) -> None:
        """Adds rows in time order: shape ``(n, channels)``, or ``(n,)`` for one channel.

        NaN is a missing number, as is what a masked array masks; a row of NaN is a missing
        sample between those that are there: it counts once a row follows, and not before
        the first of the record. Raises :exc:`ValueError` for other shapes and for numbers
        beyond 32 bits of the resolution, :exc:`TypeError` for what is no number; then none
        of the rows is taken. Ctrl-C leaves the first of many rows taken: :attr:`samples`
        gives their number. Other threads may push and ask for results meanwhile.
        """
        values = numbers(rows, "rows")
        if values.ndim == 1:
            values = values.reshape(-1, 1)
        if values.ndim != 2:
            raise ValueError(f"rows have {values.ndim} dimensions, not one or two")
        with self._lock:
            self._result = None
            self._sums.push(values)

    def gap(self, missing: int | None) -> None:
        """So many rows are missing here, as if they were NaN; ``None`` for an unknown
        number, across which no window reaches."""
        known = None if missing is None else whole(missing, "missing")
        with self._lock:
            self._result = None
            self._sums.gap(known)

    @property
    def samples(self) -> int:
        """Rows so far, missing ones not counted."""
        with self._lock:
            return self._sums.samples

    def result(self) -> Result:
        """Everything, as of a capture; the same object until rows follow."""
        with self._lock:
            if self._result is None:
                self._result = Result(json.loads(self._sums.document()))
            return self._result

    def curve(self, channel: str) -> Curve:
        """The deviation of a channel. :exc:`KeyError` for one that is not there,
        :exc:`ValueError` before the first row."""
        return self._channel(channel).curve

    def noise(self, channel: str) -> Noise | None:
        """The noise model of a channel; ``None`` for a neutral series. Raises as
        :meth:`curve`."""
        return self._channel(channel).noise

    def _channel(self, name: str) -> Channel:
        if name not in self._names:
            raise KeyError(f"{name} is none of the channels {', '.join(self._names)}")
        if self.samples == 0:
            raise ValueError("no row was pushed yet")
        return self.result().channels[name]

    def to_dict(self) -> dict[str, Any]:
        """The document ``vn100.analysis/2``."""
        return self.result().to_dict()
