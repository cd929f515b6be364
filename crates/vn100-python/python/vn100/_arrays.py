"""What is taken as an array of numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def numbers(data: ArrayLike, what: str) -> NDArray[np.float64]:
    """As contiguous floats; NaN for what is masked.

    Raises :exc:`TypeError` where something else would become numbers: texts, times,
    complex numbers, nothing.
    """
    if isinstance(data, np.ma.MaskedArray):
        data = np.ma.filled(data.astype(np.float64), np.nan)
    try:
        given = np.asarray(data)
    except ValueError as error:
        raise ValueError(f"{what} have rows of different lengths: {error}") from None
    # bool, integers, floats; objects that may be either
    if given.dtype.kind not in "biufO" or data is None:
        raise TypeError(f"{what} are no real numbers, but {given.dtype}")
    try:
        return np.ascontiguousarray(given, dtype=np.float64) if given.ndim else given.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{what} are no real numbers: {error}") from None


def whole(number: int, what: str) -> int:
    """Raises :exc:`ValueError` unless it counts samples of a record."""
    if not 0 <= number <= 1 << 53:
        raise ValueError(f"{what}: {number} is no number of samples")
    return number
