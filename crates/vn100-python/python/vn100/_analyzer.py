"""Arrays, measured as they come."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _vn100
from ._result import Curve, Noise, Result


class Analyzer:
    """Accumulates rows of numbers; results at any time, in bounded memory.

    ``channels`` are names; ``gyro_...`` are rad/s, ``accel_...`` m/s², ``mag_...``
    gauss, others neutral series without a noise model of a sensor. ``rate`` is in
    hertz. ``resolution`` is what an integer count is worth, of all channels or of
    each: give that of your sensor, and sums are exact. By default the first rows
    decide: a power of two, 2^-28 of the largest magnitude, with room for eight times
    that; the deviation is then within 1e-6 of that of the floats.

    A piece of a longer record begins at the absolute index ``start``, behind
    ``samples_before`` samples (``start`` less those missing): the states of pieces
    merge to the very bits of the whole.
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
        start: int = 0,
        samples_before: int | None = None,
    ) -> None:
        names = [channels] if isinstance(channels, str) else list(channels)
        steps: list[float] | None
        if resolution is None:
            steps = None
        elif isinstance(resolution, (int, float)):
            steps = [float(resolution)] * len(names)
        else:
            steps = [float(step) for step in resolution]
        before = start if samples_before is None else samples_before
        self._sums = _vn100.Sums(names, rate, steps, estimator, deviation, confidence, start, before)
        self._width = len(names)

    def push(self, rows: ArrayLike) -> None:
        """Adds rows in time order: shape ``(n, channels)``, or ``(n,)`` for one channel.

        NaN is a missing number; a row of NaN is a missing sample.
        """
        values = np.ascontiguousarray(rows, dtype=np.float64)
        if values.ndim == 1:
            values = values.reshape(-1, 1)
        if values.ndim != 2:
            raise ValueError(f"rows have {values.ndim} dimensions, not one or two")
        self._sums.push(values)

    def gap(self, missing: int | None) -> None:
        """So many rows are missing here; ``None`` for an unknown number, across which no
        window reaches."""
        self._sums.gap(missing)

    @property
    def samples(self) -> int:
        """Rows so far, missing ones not counted."""
        return self._sums.samples

    def result(self) -> Result:
        """Everything, as of a capture."""
        return Result(self.to_dict())

    def curve(self, channel: str) -> Curve:
        """The deviation of a channel."""
        return self.result().channels[channel].curve

    def noise(self, channel: str) -> Noise | None:
        """The noise model of a channel; ``None`` for a neutral series."""
        return self.result().channels[channel].noise

    def to_dict(self) -> dict[str, Any]:
        """The document ``vn100.analysis/1``."""
        document: dict[str, Any] = json.loads(self._sums.document())
        return document

    def state(self, name: str) -> _vn100.State:
        """What was pushed, as a recording of this name or a piece of it."""
        return self._sums.state(name)
