"""Results: documents of the program as objects and arrays."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _vn100

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from ._options import ReplayOptions


@dataclass(frozen=True)
class Parameter:
    """A noise parameter, in SI units.

    ``value`` is ``None`` unless it is estimated; where it is only bounded,
    ``upper`` is the bound. Nothing is ever guessed: see ``status``.
    """

    status: Literal["estimated", "bounded", "not-observable", "not-measurable", "moved", "model-rejected"]
    value: float | None
    lower: float | None
    upper: float | None
    unit: str

    @classmethod
    def _of(cls, found: dict[str, Any]) -> Parameter:
        return cls(*(found[name] for name in ("status", "value", "lower", "upper", "unit")))

    def __str__(self) -> str:
        if self.value is not None:
            digits = _digits(self.value, self.lower, self.upper)
            ends = f"{_short(self.lower, digits)} to {_short(self.upper, digits)}"
            return f"{_short(self.value, digits)} {self.unit} ({ends})"
        if self.status == "bounded" and self.upper is not None:
            return f"<= {_short(self.upper)} {self.unit}"
        return self.status.replace("-", " ")


@dataclass(frozen=True)
class Noise:
    """The noise model of a channel: white noise N, bias instability B, rate random
    walk K, ramp R (IEEE Std 952), and how well it fits the curve.

    ``chi2``, ``dof`` and ``p`` are ``None`` where nothing was fitted.
    """

    white: Parameter | None
    bias_instability: Parameter | None
    rate_random_walk: Parameter | None
    rate_ramp: Parameter | None
    quantization: Parameter | None
    chi2: float | None
    dof: int | None
    p: float | None

    @classmethod
    def _of(cls, noise: dict[str, Any]) -> Noise:
        def of(term: str) -> Parameter | None:
            return Parameter._of(noise[term]) if noise[term] else None

        fit = noise["fit"] or {}
        return cls(
            white=of("white"),
            bias_instability=of("bias_instability"),
            rate_random_walk=of("rate_random_walk"),
            rate_ramp=of("rate_ramp"),
            quantization=of("quantization"),
            chi2=fit.get("chi2"),
            dof=fit.get("dof"),
            p=fit.get("p"),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """The Allan or Hadamard deviation over averaging time, octave by octave.

    All arrays have the shape ``(octaves,)``. ``deviation``, ``lower`` and
    ``upper`` are in ``unit``; NaN where a number is not known, as are intervals
    below two degrees of freedom. The interval rests on the equivalent degrees of
    freedom of the noise identified at each octave (NIST SP 1065), and holds for
    one octave at a time. ``alpha`` is the exponent of that noise, 127 for unknown.
    """

    unit: str
    kind: str
    estimator: str
    confidence: float
    m: NDArray[np.uint64]
    tau: NDArray[np.float64]
    deviation: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    edf: NDArray[np.float64]
    alpha: NDArray[np.int8]
    terms: NDArray[np.uint64]

    @classmethod
    def _of(cls, channel: dict[str, Any]) -> Curve:
        allan = channel["allan"]

        def column(name: str) -> NDArray[np.float64]:
            return np.array([np.nan if p[name] is None else p[name] for p in allan["points"]], np.float64)

        points = allan["points"]
        return cls(
            unit=channel["unit"],
            kind=allan["deviation"],
            estimator=allan["estimator"],
            confidence=allan["confidence"],
            m=np.array([p["m"] for p in points], np.uint64),
            tau=column("tau_s"),
            deviation=column("deviation"),
            lower=column("lower"),
            upper=column("upper"),
            edf=column("edf"),
            alpha=np.array([127 if p["alpha"] is None else p["alpha"] for p in points], np.int8),
            terms=np.array([p["terms"] for p in points], np.uint64),
        )

    def __repr__(self) -> str:
        return f"<vn100.Curve: {self.kind} deviation at {len(self.tau)} averaging times>"

    def plot(self, ax: Axes | None = None, label: str | None = None) -> Axes:
        """Draws the curve and its intervals on matplotlib axes, new ones by default.

        Needs matplotlib: ``pip install matplotlib``.
        """
        if ax is None:
            try:
                import matplotlib.pyplot as plt
            except ImportError as error:
                raise ImportError(f"plot() needs matplotlib: pip install matplotlib ({error})") from None
            _, ax = plt.subplots(layout="constrained")
        # ten colours, then the same with another style
        style = ("-", "--", ":", "-.")[len(ax.lines) // 10 % 4]
        (line,) = ax.loglog(self.tau, self.deviation, style, marker=".", label=label)
        ax.fill_between(self.tau, self.lower, self.upper, color=line.get_color(), alpha=0.25, linewidth=0)
        ax.set_xlabel("averaging time in s")
        ax.set_ylabel(f"{self.kind.capitalize()} deviation" + (f" in {self.unit}" if self.unit else ""))
        ax.grid(True, which="both", alpha=0.3)
        if label is not None and len(ax.lines) > 6:
            ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        elif label is not None:
            ax.legend()
        return ax


@dataclass(frozen=True, eq=False, repr=False)
class Channel:
    """One channel: statistics in its unit, curve, noise model, spectrum.

    ``frequency`` (Hz) and ``density`` (unit²/Hz, one-sided, Welch's method) have the
    same shape, and none points without a spectrum.
    """

    name: str
    unit: str
    count: int
    mean: float | None
    std: float | None
    curve: Curve
    noise: Noise | None
    frequency: NDArray[np.float64]
    density: NDArray[np.float64]

    @classmethod
    def _of(cls, channel: dict[str, Any]) -> Channel:
        statistics, spectrum = channel["statistics"], channel["spectrum"] or {}
        density = np.array(spectrum.get("density", []), np.float64)
        return cls(
            name=channel["name"],
            unit=channel["unit"],
            count=statistics["count"],
            mean=statistics["mean"],
            std=statistics["std"],
            curve=Curve._of(channel),
            noise=Noise._of(channel["noise"]) if channel["noise"] else None,
            frequency=(spectrum.get("step_hz") or 0.0) * np.arange(1, len(density) + 1, dtype=np.float64),
            density=density,
        )

    def __repr__(self) -> str:
        return f"<vn100.Channel {self.name}: {self.count} samples in {self.unit or 'no unit'}>"


class Result:
    """The result of a capture, or of the arrays of an :class:`Analyzer`.

    ``channels`` maps names to :class:`Channel`; ``warnings`` are what limits the
    result, the gravest first; ``error`` says why a capture was not read to its end.
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self._document = document
        self.channels: Mapping[str, Channel] = {c["name"]: Channel._of(c) for c in document["channels"]}
        self.warnings: list[str] = [warning["text"] for warning in document["warnings"]]
        self.name: str = document["source"]["name"]
        self.error: str | None = document["source"].get("error")
        self.rate: float | None = document["timing"]["rate_hz"]
        self.samples: int = document["timing"]["samples"]
        self.missing: int | None = document["timing"]["missing"]

    def to_dict(self) -> dict[str, Any]:
        """The document ``vn100.analysis/2``, as ``vn100 replay --json`` prints it."""
        return self._document

    def __repr__(self) -> str:
        rate = "an unknown rate" if self.rate is None else f"{self.rate:g} Hz"
        return f"<vn100.Result {self.name}: {self.samples} samples at {rate}, {len(self.channels)} channels>"

    def plot(self, *names: str, ax: Axes | None = None) -> Axes:
        """Draws the curves of these channels, of all by default. Where their units differ,
        each has its unit beside its name."""
        drawn = names or tuple(self.channels)
        differ = len({self.channels[name].unit for name in drawn}) > 1
        for name in drawn:
            curve = self.channels[name].curve
            ax = curve.plot(ax, label=f"{name} ({curve.unit or 'no unit'})" if differ else name)
        if ax is None:
            raise ValueError("the result has no channel to draw")
        if differ:
            ax.set_ylabel(f"{curve.kind.capitalize()} deviation in the unit of each channel")
        return ax

    def _repr_html_(self) -> str:
        def row(channel: Channel) -> str:
            terms = (_text(channel.noise, term) for term in ("white", "bias_instability", "rate_random_walk"))
            cells = "".join(f"<td style='white-space:nowrap'>{html.escape(text)}</td>" for text in terms)
            return f"<tr><td>{html.escape(channel.name)}</td>{cells}</tr>"

        title = html.escape(repr(self).strip("<>"))
        error = f"<p><b>{html.escape(self.error)}</b></p>" if self.error else ""
        head = "".join(f"<th>{name}</th>" for name in ("channel", "N", "B", "K"))
        rows = "".join(row(channel) for channel in self.channels.values())
        notes = "".join(f"<li>{html.escape(warning)}</li>" for warning in self.warnings)
        return f"<p>{title}</p>{error}<table><tr>{head}</tr>{rows}</table><ul>{notes}</ul>"


def _text(noise: Noise | None, term: str) -> str:
    found = getattr(noise, term) if noise else None
    return str(found) if found else "–"


def _digits(value: float, lower: float | None, upper: float | None) -> int:
    """Three, or as many as show how wide the interval is."""
    width = 0.0 if lower is None or upper is None else upper - lower
    if not width > 0.0 or value == 0.0:
        return 3
    return min(max(3, math.floor(math.log10(abs(value))) - math.floor(math.log10(width)) + 2), 17)


def _short(value: float | None, digits: int = 3) -> str:
    """So many digits, those that are zero too."""
    return "?" if value is None else f"{value:#.{digits}g}".removesuffix(".")


def replay(path: str | os.PathLike[str], *parts: str | os.PathLike[str], **options: Unpack[ReplayOptions]) -> Result | Any:
    """Measures a recorded capture: text, raw bytes, CSV, MCAP, ROS bags, also packed.
    ``parts`` are the files in which a recording continues, in any order; a part that is
    missing between them is a :exc:`UserWarning`.

    Options have the names of ``vn100 replay`` with ``_`` for ``-``: ``rate``,
    ``estimator``, ``deviation``, ``confidence``, ``skip`` and ``duration`` (seconds, both
    from the first sample, so that ``duration`` includes what ``skip`` excludes),
    ``quantization``, ``window``, ``compensated``, ``columns``, ``topic``,
    ``accept_unchecked``, ``measure``. A given ``rate`` is taken even
    where the times of a capture show another, but not for ``BINARY`` packets, whose rate
    is that of the clock in them. A capture with several streams gives a list of
    results. Other threads run meanwhile, and Ctrl-C ends it.

    Raises :exc:`FileNotFoundError`, another :exc:`OSError` or :exc:`CaptureError` where
    nothing could be measured, :exc:`ValueError` and :exc:`TypeError` for options, and
    :exc:`ValueError` for files that are not parts of one recording.
    """
    found = [Result(json.loads(document)) for document in _vn100.replay(path, *parts, **options)]
    # which of both it is only the capture shows: `Any` in the type stands for the list
    return found[0] if len(found) == 1 else found
