"""Samples with known noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from . import _vn100
from ._arrays import whole

# in the order in which they are passed on
_TERMS = ("mean", "N", "B", "K", "R")


class Simulated(Mapping[str, NDArray[np.float64]]):
    """Arrays of samples, of shape ``(n,)``, by the names of their channels, with the noise that
    is in them: ``truth["gyro_x"]["N"]``; ``rate`` is in hertz."""

    def __init__(self, arrays: dict[str, NDArray[np.float64]], truth: dict[str, dict[str, float]], rate: int) -> None:
        self._arrays, self.truth, self.rate = arrays, truth, rate

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        samples = max((len(array) for array in self._arrays.values()), default=0)
        return f"<vn100.Simulated: {samples} samples at {self.rate} Hz, {', '.join(self)}>"


def simulate(channels: Mapping[str, Mapping[str, float]], *, seconds: float, rate: int, seed: int = 0) -> Simulated:
    """Samples of the noise that is asked for, as the emulated sensor makes it.

    ``channels`` has for each name the terms of its noise, zero unless given, in the unit u
    of the channel: ``N`` (white, u/sqrt(Hz): the Allan deviation at 1 s), ``B`` (bias
    instability, u: flicker whose deviation is flat at 0.664 B), ``K`` (random walk,
    u/sqrt(s)), ``R`` (ramp, u/s) and ``mean`` (u). ``rate`` is a whole number of hertz. The
    same ``seed`` gives the same numbers on every system; channels are independent.

    ``Analyzer(list(samples), rate=samples.rate).push(samples)`` measures them.

    Raises :exc:`ValueError` for terms that do not exist, are negative or no number.
    """
    hz, count = whole(rate, "rate"), round(float(seconds) * rate)
    truth = {}
    for name, given in channels.items():
        if unknown := [term for term in given if term not in _TERMS]:
            raise ValueError(f"{name}: {unknown[0]!r} is none of {', '.join(_TERMS)}")
        truth[name] = {term: float(given.get(term, 0.0)) for term in _TERMS}
        for term, value in truth[name].items():
            if not np.isfinite(value) or (value < 0 and term in "NBK"):
                raise ValueError(f"{name}: {term} of {value} does not exist")
    arrays = _vn100.simulated([tuple(terms.values()) for terms in truth.values()], hz, count, whole(seed, "seed"))
    return Simulated(dict(zip(truth, arrays, strict=True)), truth, hz)
