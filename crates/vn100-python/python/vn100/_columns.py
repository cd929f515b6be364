"""What the columns of arrays are: names, quantities, units, times."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import numbers

# of a sensor, or of a neutral series
Quantity: TypeAlias = Literal["gyro", "accel", "mag"] | Literal["value"]

QUANTITIES: tuple[Quantity, ...] = ("gyro", "accel", "mag", "value")

# the quantity of a unit, and its factor to rad/s, m/s^2 and gauss
UNITS: dict[str, tuple[Quantity, float]] = {
    "rad/s": ("gyro", 1.0),
    "mrad/s": ("gyro", 1e-3),
    "deg/s": ("gyro", math.pi / 180),
    "deg/h": ("gyro", math.pi / 180 / 3600),
    "rpm": ("gyro", math.pi / 30),
    "m/s^2": ("accel", 1.0),
    "cm/s^2": ("accel", 1e-2),
    "ft/s^2": ("accel", 0.3048),
    "g": ("accel", 9.80665),
    "mg": ("accel", 9.80665e-3),
    "ug": ("accel", 9.80665e-6),
    "gauss": ("mag", 1.0),
    "mgauss": ("mag", 1e-3),
    "T": ("mag", 1e4),
    "uT": ("mag", 1e-2),
    "nT": ("mag", 1e-5),
}

_WORDS = {
    "gyro": "gyro gyr gyroscope g w omega rate angularrate angularvelocity angvel rotationrate",
    "accel": "accel acc acceleration accelerometer linearacceleration specificforce a",
    "mag": "mag magn magnetometer magneticfield m",
}


def suggested(name: str) -> str | None:
    """The name of this package for what a name such as ``GyroX``, ``wx`` or ``acc_x`` means."""
    split = re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower()
    tokens = re.findall(r"[a-z]+", split)
    for begin in range(len(tokens)):
        for end in range(begin + 1, len(tokens) + 1):
            word, axis = "".join(tokens[begin:end])[:-1], tokens[end - 1][-1]
            for quantity, words in _WORDS.items():
                # a single letter is a quantity only at the beginning
                if axis in "xyz" and word in words.split() and (len(word) > 1 or begin == 0):
                    return f"{quantity}_{axis}"
    return None


def quantities(
    names: Sequence[str], units: Mapping[str, str], given: Quantity | Mapping[str, Quantity] | None
) -> tuple[list[Quantity], NDArray[np.float64]]:
    """The quantity of each channel, and the factor of its numbers to SI units (gauss for a field)."""
    if not names:
        raise ValueError('name a channel at least, as in channels=["gyro_x"]')
    twice = next((name for place, name in enumerate(names) if name in names[:place]), None)
    if twice is not None:
        raise ValueError(f"the channel {twice} is named twice")
    told = dict.fromkeys(names, given) if isinstance(given, str) else dict(given or {})
    for option, mapping in (("units", units), ("quantity", told)):
        for name in mapping:
            if name not in names:
                raise ValueError(f"{option}: {name} is none of the channels {', '.join(names)}")
    found: list[Quantity] = []
    factors = []
    for name in names:
        unit = units.get(name)
        by_unit, factor = (None, 1.0) if unit is None else _unit(unit)
        first = name.split("_")[0]
        by_name: Quantity | None = next((q for q in QUANTITIES[:3] if q == first), None)
        quantity = told.get(name) or by_unit or by_name
        if quantity is None:
            near = suggested(name)
            if near is not None:
                raise ValueError(
                    f"{name}: call the channel {near}, or give units={{{name!r}: ...}}, "
                    f'or quantity={{{name!r}: "value"}} for a neutral series'
                )
            quantity = "value"
        if quantity not in QUANTITIES:
            raise ValueError(f"quantity: {quantity!r} is none of {', '.join(QUANTITIES)}")
        if by_unit is not None and (by_unit != quantity or by_name not in (None, by_unit)):
            raise ValueError(f"units: {unit} is no unit of {name}, which is {by_name or quantity}")
        found.append(quantity)
        factors.append(factor)
    return found, np.array(factors)


def _unit(unit: str) -> tuple[Quantity, float]:
    plain = unit.replace("°", "deg").replace("²", "^2").replace("µ", "u").replace("dps", "deg/s")
    if plain not in UNITS:
        raise ValueError(f"units: {unit!r} is none of {', '.join(UNITS)}")
    return UNITS[plain]


def matrix(rows: Any, names: Sequence[str]) -> NDArray[np.float64]:
    """Rows with the columns of these names: by name if the rows have names, else by position."""
    labels = _labels(rows)
    if labels is None:
        values = numbers(rows, "rows")
        if values.ndim == 1:
            values = values.reshape(-1, 1)
        if values.ndim != 2:
            raise ValueError(f"rows have {values.ndim} dimensions, not one or two")
        if values.shape[1] != len(names):
            raise ValueError(f"rows have {values.shape[1]} numbers, and there are {len(names)} channels")
        return values
    for name in names:
        if labels.count(name) != 1:
            how = "stands twice" if name in labels else "is not there"
            near = [label for label in labels if suggested(str(label)) == name]
            hint = f"; {near[0]} may be meant: rename it" if near and name not in labels else ""
            raise ValueError(f"the column {name} {how} among {', '.join(map(str, labels))}{hint}")
    columns = [numbers(rows[name], name) for name in names]
    return np.ascontiguousarray(np.column_stack(columns))


def _labels(rows: Any) -> list[Any] | None:
    """The names of the columns; ``None`` if they are only numbered."""
    if isinstance(rows, Mapping):
        # an empty one is no rows of numbers
        return list(rows) or None
    fields = getattr(getattr(rows, "dtype", None), "names", None)
    if fields:
        return list(fields)
    columns = getattr(rows, "columns", None)
    labels = None if columns is None else list(columns)
    return labels if labels and any(isinstance(label, str) for label in labels) else None


def times(rows: Any, t: ArrayLike | None, count: int) -> NDArray[np.float64] | None:
    """Seconds of each row, from ``t`` or from an index of times; ``None`` if nothing tells them."""
    index = getattr(rows, "index", None)
    if t is None:
        if index is None or callable(index):
            return None
        stamps = np.asarray(index.values)
        if stamps.dtype.kind in "iu":
            steps = np.diff(stamps)
            if (steps == 1).all():
                return None
            raise ValueError("the index of whole numbers has other steps than 1: give t=, in seconds, or reset_index(drop=True)")
        if stamps.dtype.kind not in "mMf":
            raise ValueError(f"the index ({stamps.dtype}) is no time: give t=, in seconds, or reset_index(drop=True)")
    else:
        stamps = np.asarray(t)
        if stamps.dtype.kind not in "iufmM":
            raise TypeError(f"t is no time, but {stamps.dtype}")
    if stamps.shape != (count,):
        raise ValueError(f"t has the shape {stamps.shape}, and there are {count} rows")
    if stamps.dtype.kind in "mM":
        if np.isnat(stamps).any():
            raise ValueError("a time is missing (NaT)")
        unit = "timedelta64[ns]" if stamps.dtype.kind == "m" else "datetime64[ns]"
        return stamps.astype(unit).astype(np.int64) / 1e9
    seconds = stamps.astype(np.float64)
    if not np.isfinite(seconds).all():
        raise ValueError("a time is not finite")
    return seconds


def steps_of(seconds: NDArray[np.float64], last: float | None) -> NDArray[np.float64]:
    """The intervals before each row, from the second one on, or from the first after ``last``."""
    steps = np.diff(seconds if last is None else np.concatenate([[last], seconds]))
    wrong = np.flatnonzero(~(steps > 0))
    if len(wrong):
        raise ValueError(f"times do not increase at row {wrong[0] + (last is None)}: sort the rows, and drop those that stand twice")
    return steps


def rate_of(steps: NDArray[np.float64]) -> float:
    """The sample rate that the intervals show: the number of them over their sum, gaps counted."""
    if len(steps) == 0:
        raise ValueError("one time shows no rate: give rate=, in hertz")
    median = float(np.median(steps))
    counts = np.maximum(np.round(steps / median), 1)
    if np.mean(np.abs(steps / median - counts) > 0.25) > 0.05:
        raise ValueError("the intervals of the times are too uneven to show a rate: give rate= and no times")
    return float(counts.sum() / steps.sum())
