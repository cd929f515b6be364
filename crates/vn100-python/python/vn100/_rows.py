"""The samples of captures."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _vn100

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ReadingOptions

Block: TypeAlias = tuple[NDArray[np.int64], NDArray[np.float64]]


def captures(*paths: str | os.PathLike[str]) -> list[list[str]]:
    """Every capture below the paths, as ``vn100 archive`` finds them: the files of each,
    one, or the parts of a recording in their order.

    Files of a folder are known by their endings, packed ones too, and nothing hidden is
    one; a path itself is a capture whatever it is called. Each is for
    ``archive_rows(*files)`` or ``replay(*files)``.

    Raises :exc:`TypeError` for what is no path. Nothing is opened: that a file is not there
    is said by what reads it.
    """
    return [[os.fspath(file) for file in files] for files in _vn100.captures(*paths)]


class Rows(Iterator[Block]):
    """The samples of a capture, block by block, as :func:`rows` gives them; threads may
    share them, and each block is given once."""

    def __init__(self, path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReadingOptions]) -> None:
        self._rows = _vn100.Rows(path, *parts, **options)
        self._name = os.path.basename(path)
        self._lock = threading.Lock()
        self._channels, self._units = self._rows.channels, self._rows.units

    @property
    def channels(self) -> list[str]:
        """Names of the channels, as the values have them."""
        return list(self._channels)

    @property
    def units(self) -> list[str]:
        """Unit of each channel; empty for a neutral series."""
        return list(self._units)

    def __next__(self) -> Block:
        with self._lock:
            return next(self._rows)

    def __repr__(self) -> str:
        return f"<vn100.Rows of {self._name}: {len(self._channels)} channels>"


def rows(path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReadingOptions]) -> Rows:
    """The samples of a capture, block by block: pairs of times and values. ``parts`` are
    the files in which a recording continues, in any order.

    Times are ``int64`` nanoseconds of shape ``(n,)``: of the sensor's clock, from its
    start, where the samples carry its time; else of the arrival at the host, since
    1970-01-01 UTC in a recording; the smallest ``int64`` where a capture has none.
    Values are ``float64`` of shape ``(n, channels)`` in ``units``; NaN for what a row
    lacks. The iterator has ``channels`` and ``units``.

    Options are those of :func:`replay` that concern reading: ``accept_unchecked``,
    ``columns``, ``measure``, ``topic``. Raises as :func:`replay`.
    """
    return Rows(path, *parts, **options)
