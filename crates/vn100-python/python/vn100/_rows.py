"""The samples of captures."""

from __future__ import annotations

import os
from typing import Any

from . import _vn100


def rows(path: str | os.PathLike[str], **options: Any) -> _vn100.Rows:
    """The samples of a capture, block by block: pairs of times and values.

    Times are ``int64`` nanoseconds of shape ``(n,)``: of the sensor since it started,
    else of the arrival; the smallest ``int64`` where a capture has none. Values are
    ``float64`` of shape ``(n, channels)`` in ``units``; NaN for what a row lacks.
    The iterator has ``channels`` and ``units``.
    """
    return _vn100.Rows(os.fspath(path), **options)
