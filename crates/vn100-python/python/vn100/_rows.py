"""The samples of captures."""

from __future__ import annotations

import os
from typing import Any

from . import _vn100


def captures(*paths: str | os.PathLike[str]) -> list[list[str]]:
    """Every capture below the paths, as ``vn100 archive`` finds them: the files of each,
    one, or the parts of a recording in their order.

    Files of a folder are known by their endings, packed ones too, and nothing hidden is
    one; a path itself is a capture whatever it is called. Each is for
    ``State.of_file(*files)`` or ``replay(*files)``.
    """
    return [[os.fspath(file) for file in files] for files in _vn100.captures(*paths)]


def rows(path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Any) -> _vn100.Rows:
    """The samples of a capture, block by block: pairs of times and values. ``parts`` are
    the files in which a recording continues.

    Times are ``int64`` nanoseconds of shape ``(n,)``: of the sensor since it started,
    else of the arrival; the smallest ``int64`` where a capture has none. Values are
    ``float64`` of shape ``(n, channels)`` in ``units``; NaN for what a row lacks.
    The iterator has ``channels`` and ``units``.
    """
    return _vn100.Rows(path, *parts, **options)
