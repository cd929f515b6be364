"""The options of a capture, by their types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict


class ReadingOptions(TypedDict, total=False):
    """How a capture is read."""

    accept_unchecked: bool | None
    columns: str | None
    measure: Literal["sentences", "packets"] | None
    topic: str | None


class ReplayOptions(ReadingOptions, total=False):
    """How a capture is read and measured."""

    coast: Sequence[float | tuple[float, float]] | None
    compensated: bool | Literal["yes", "no"] | None
    confidence: float | None
    deviation: Literal["allan", "hadamard"] | None
    duration: float | None
    estimator: Literal["strided", "full", "plain"] | None
    quantization: bool | None
    rate: float | None
    skip: float | None
    taus: Literal["octave", "decade"] | Sequence[float] | None
    window: int | None
