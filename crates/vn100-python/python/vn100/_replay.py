"""Captures, measured."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, TypeAlias, overload

from . import _vn100
from ._result import Result

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ReplayOptions

Source: TypeAlias = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes]


class Results(Sequence[Result]):
    """The results of a capture: one for each stream, such as a topic of a bag."""

    def __init__(self, results: Sequence[Result]) -> None:
        self._results = list(results)

    @overload
    def __getitem__(self, place: int) -> Result: ...
    @overload
    def __getitem__(self, place: slice) -> Results: ...
    def __getitem__(self, place: int | slice) -> Result | Results:
        if isinstance(place, str):
            raise TypeError(f"results are counted: take .only[{place!r}], or [0][{place!r}] of several")
        return Results(self._results[place]) if isinstance(place, slice) else self._results[place]

    def __len__(self) -> int:
        return len(self._results)

    @property
    def only(self) -> Result:
        """The result of a capture with one stream. Raises :exc:`ValueError` if there are others."""
        if len(self) != 1:
            names = ", ".join(result.name for result in self)
            raise ValueError(f"there are {len(self)} results, not one ({names}): take one by its place, or give topic=")
        return self._results[0]

    def __repr__(self) -> str:
        return f"<vn100.Results: {', '.join(map(repr, self))}>"

    def _repr_html_(self) -> str:
        return "".join(result._repr_html_() for result in self)


def replay(source: Source, *parts: str | os.PathLike[str], **options: Unpack[ReplayOptions]) -> Results:
    """Measures a recorded capture: text, raw bytes, CSV, MCAP, ROS bags, also packed.
    ``source`` is its path, its bytes, or a binary file that is open, read from its present
    position. ``parts`` are the files in which a recording continues, in any order; a part
    that is missing between them is a :exc:`UserWarning`.

    Gives a sequence of results, one for each stream: ``.only`` is that of a capture with
    one. Options have the names of ``vn100 replay`` with ``_`` for ``-``: ``rate``,
    ``estimator``, ``deviation``, ``confidence``, ``skip`` and ``duration`` (seconds, both
    from the first sample, so that ``duration`` includes what ``skip`` excludes),
    ``quantization``, ``taus`` (``"octave"``, or with ``estimator="full"`` ``"decade"`` or a
    list of seconds), ``window``, ``compensated``, ``columns``, ``topic``,
    ``coast`` (seconds, or pairs of rest and coast), ``accept_unchecked``, ``measure``. A given ``rate`` is taken even if the times of a
    capture show another, but not for ``BINARY`` packets, whose rate is that of the clock in
    them. Other threads run meanwhile, and Ctrl-C ends it.

    Raises :exc:`FileNotFoundError`, another :exc:`OSError` or :exc:`CaptureError` if nothing
    could be measured, :exc:`ValueError` and :exc:`TypeError` for options, and
    :exc:`ValueError` for files that are not parts of one recording.
    """
    with _as_file(source) as path:
        return Results([Result(measured) for measured in _vn100.replay(path, *parts, **options)])


@contextmanager
def _as_file(source: Source) -> Iterator[str | os.PathLike[str]]:
    """A path; what is no file yet is copied to one, since some formats are read from their end."""
    if isinstance(source, (str, os.PathLike)):
        yield source
        return
    with tempfile.TemporaryDirectory() as folder:
        given = getattr(source, "name", None)
        # the name says what a file of a phone holds
        path = Path(folder) / (os.path.basename(given) if isinstance(given, str) and os.path.basename(given) else "bytes")
        with path.open("wb") as copy:
            if isinstance(source, (bytes, bytearray, memoryview)):
                copy.write(source)
            else:
                if isinstance(source.read(0), str):
                    raise TypeError("the file is open as text: open it with mode \"rb\"")
                shutil.copyfileobj(source, copy)
        yield path
