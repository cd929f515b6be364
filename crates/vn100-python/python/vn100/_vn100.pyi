import os
from collections.abc import Iterator
from typing import final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self, Unpack

from ._options import ReadingOptions, ReplayOptions

__all__ = ["CaptureError", "Measured", "Rows", "Sums", "archive_rows", "captures", "deviations", "replay", "simulated"]

class CaptureError(Exception): ...

def archive_rows(
    path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReplayOptions]
) -> list[str]: ...
def captures(*paths: str | os.PathLike[str]) -> list[list[os.PathLike[str]]]: ...
def replay(path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReplayOptions]) -> list[Measured]: ...
def deviations(
    data: NDArray[np.float64],
    work: NDArray[np.float64],
    is_phase: bool,
    hadamard: bool,
    overlapping: bool,
    factors: list[int],
) -> tuple[list[float], list[int]]: ...
def simulated(
    channels: list[tuple[float, ...]], rate: int, samples: int, seed: int
) -> list[NDArray[np.float64]]: ...

@final
class Rows(Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]):
    def __new__(
        cls, path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReadingOptions]
    ) -> Self: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def units(self) -> list[str]: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...

@final
class Measured:
    def document(self) -> str: ...
    def remedies(self) -> list[list[str]]: ...
    def page(self, span: float) -> bytes: ...
    def filter_file(self, name: str, span: float, scale_factor: float | None) -> str: ...

@final
class Sums:
    def __new__(
        cls,
        channels: list[tuple[str, str]],
        rate: float,
        resolution: list[float],
        estimator: str,
        deviation: str,
        confidence: float,
        compensated: bool | str | None,
        taus: str | list[float] | None,
    ) -> Self: ...
    def push(self, rows: NDArray[np.float64], gaps: list[tuple[int, int]]) -> None: ...
    def gap(self, missing: int | None) -> None: ...
    @property
    def samples(self) -> int: ...
    def result(self) -> Measured: ...
