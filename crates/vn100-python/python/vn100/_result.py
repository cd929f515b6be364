"""Results: documents of the program as objects and arrays."""

from __future__ import annotations

import html
import importlib
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _vn100
from ._columns import suggested

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# the fields of a noise model that are parameters
TERMS = ("white", "bias_instability", "rate_random_walk", "rate_ramp", "quantization")


def frame(columns: dict[str, Any]) -> Any:
    """A frame of pandas if that is installed, else the columns by name."""
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        return columns
    return pandas.DataFrame(columns)


@dataclass(frozen=True)
class ResultWarning:
    """What limits a result: the kind as a code, how grave it is, the channels concerned
    (none means all), what was found, and what can be done, in arguments of this package
    if one helps."""

    code: str
    severity: Literal["problem", "caution", "note"]
    channels: list[str]
    text: str
    remedies: list[str]

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Parameter:
    """A noise parameter, in SI units unless :meth:`to` has converted it.

    ``value`` is ``None`` unless it is estimated; where it is only bounded,
    ``upper`` is the bound. Nothing is ever guessed: see ``status``.
    """

    status: Literal["estimated", "bounded", "not-observable", "not-measurable", "moved", "model-rejected"]
    value: float | None
    lower: float | None
    upper: float | None
    unit: str
    # the same in other units, by their names; densities count both sides of the spectrum
    _others: Mapping[str, Mapping[str, Any]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def _of(cls, found: dict[str, Any]) -> Parameter:
        others = {other["unit"]: other for other in found["conventions"] if other["sides"] != "one"}
        return cls(found["status"], found["value"], found["lower"], found["upper"], found["unit"], others)

    def to(self, unit: str) -> Parameter:
        """The same in another unit, such as ``deg/sqrt(h)`` (or ``°/√h``) for N of a gyroscope.

        Densities are two-sided. Raises :exc:`ValueError` for a unit that is not in use for
        the parameter, and for a parameter without a number.
        """
        plain = re.sub(r"√(\w+)", r"sqrt(\1)", unit.replace("°", "deg").replace("²", "^2").replace("µ", "u"))
        if plain == self.unit:
            return self
        if self.value is None and self.upper is None:
            raise ValueError(f"the parameter has no number to convert: {self.status.replace('-', ' ')}")
        if plain not in self._others:
            known = ", ".join([self.unit, *self._others])
            raise ValueError(f"{unit} is none of the units of this parameter: {known}")
        other = self._others[plain]
        return replace(self, value=other["value"], lower=other["lower"], upper=other["upper"], unit=plain)

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
    walk K, ramp R (IEEE Std 952), each with its unit, and how well they fit the curve.

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
        fit = noise["fit"] or {}
        return cls(
            **{term: Parameter._of(noise[term]) if noise[term] else None for term in TERMS},
            chi2=fit.get("chi2"),
            dof=fit.get("dof"),
            p=fit.get("p"),
        )

    def __str__(self) -> str:
        found = ((letter, getattr(self, term)) for letter, term in zip("NBKRQ", TERMS, strict=True))
        return ", ".join(f"{letter} {parameter}" for letter, parameter in found if parameter)


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """The Allan or Hadamard deviation over averaging time, octave by octave.

    All arrays have the shape ``(octaves,)``. ``deviation``, ``lower`` and
    ``upper`` are in ``unit``; NaN where a number is not known, as are intervals
    below two degrees of freedom. The interval rests on the equivalent degrees of
    freedom of the noise identified at each octave (NIST SP 1065), and holds for
    one octave at a time. ``alpha`` is the exponent of that noise, 127 for unknown.
    ``fitted`` is the deviation of the noise model, NaN without one.
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
    fitted: NDArray[np.float64]

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
            fitted=column("fitted"),
        )

    def __repr__(self) -> str:
        return f"<vn100.Curve: {self.kind} deviation at {len(self.tau)} averaging times>"

    def frame(self) -> Any:
        """The octaves as rows: a frame of pandas if that is installed, else the columns by name."""
        names = ("m", "tau", "deviation", "lower", "upper", "edf", "alpha", "terms", "fitted")
        return frame({name: getattr(self, name) for name in names})

    def plot(self, ax: Axes | None = None, label: str | None = None) -> Axes:
        """Draws the curve with its intervals, and its model as a dashed line, on matplotlib
        axes, new ones by default.

        Needs matplotlib: ``pip install matplotlib``.
        """
        if ax is None:
            ax = _figure(1).axes[0]
        (line,) = ax.loglog(self.tau, self.deviation, marker=".", label=label)
        if not np.isnan(self.fitted).all():
            ax.plot(self.tau, self.fitted, "--", color=line.get_color(), linewidth=1)
        ax.fill_between(self.tau, self.lower, self.upper, color=line.get_color(), alpha=0.25, linewidth=0)
        ax.set_xlabel("averaging time in s")
        ax.set_ylabel(f"{self.kind.capitalize()} deviation" + (f" in {self.unit}" if self.unit else ""))
        ax.grid(True, which="both", alpha=0.3)
        if label is not None:
            ax.legend()
        return ax


def _figure(count: int) -> Figure:
    """A figure with so many axes, one below the other."""
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError(f"plot() needs matplotlib: pip install matplotlib ({error})") from None
    figure, _ = plt.subplots(count, layout="constrained", figsize=(6.4, 4.8 * count), squeeze=False)
    return figure


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


class Result(Mapping[str, Channel]):
    """The result of a capture, or of the arrays of an :class:`Analyzer`: its channels by name.

    ``warnings`` are what limits the result, the gravest first; ``error`` says why a capture
    was not read to its end. ``rate`` is in hertz, ``missing`` the number of dropped samples;
    each is ``None`` if it is not known. A pickled result keeps all but :meth:`report` and
    :meth:`export`, which need the measurement itself.
    """

    def __init__(self, measured: _vn100.Measured) -> None:
        self._measured: _vn100.Measured | None = measured
        self._document: dict[str, Any] = json.loads(measured.document())
        document, remedies = self._document, measured.remedies()
        self._channels = {c["name"]: Channel._of(c) for c in document["channels"]}
        self.warnings: list[ResultWarning] = [
            ResultWarning(found["kind"], found["severity"], found["channels"], found["text"], words)
            for found, words in zip(document["warnings"], remedies, strict=True)
        ]
        self.name: str = document["source"]["name"]
        self.error: str | None = document["source"].get("error")
        self.rate: float | None = document["timing"]["rate_hz"]
        self.samples: int = document["timing"]["samples"]
        self.missing: int | None = document["timing"]["missing"]

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_measured": None}

    def __getitem__(self, name: str) -> Channel:
        if name in self._channels:
            return self._channels[name]
        near = suggested(str(name))
        hint = f"; {near} may be meant" if near in self._channels else ""
        raise KeyError(f"{name} is none of the channels {', '.join(self._channels)}{hint}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def __contains__(self, name: object) -> bool:
        return name in self._channels

    def to_dict(self) -> dict[str, Any]:
        """The document ``vn100.analysis/2``, as ``vn100 replay --json`` prints it."""
        return self._document

    def parameters(self) -> Any:
        """Every noise parameter as a row, in SI units: a frame of pandas if that is installed,
        else the columns by name. NaN if a number is not known: see ``status``."""
        found = [
            (name, term, parameter)
            for name, channel in self.items()
            for term in TERMS
            if channel.noise is not None and (parameter := getattr(channel.noise, term)) is not None
        ]

        def ends(end: str) -> NDArray[np.float64]:
            return np.array([getattr(parameter, end) for *_, parameter in found], np.float64)

        return frame(
            {
                "channel": [name for name, *_ in found],
                "parameter": [term for _, term, _ in found],
                "status": [parameter.status for *_, parameter in found],
                "value": ends("value"),
                "lower": ends("lower"),
                "upper": ends("upper"),
                "unit": [parameter.unit for *_, parameter in found],
            }
        )

    def curve(self, name: str) -> Any:
        """The deviation of a channel as a frame: :meth:`Curve.frame`."""
        return self[name].curve.frame()

    def report(self, path: str | os.PathLike[str], *, span: float = 60.0, overwrite: bool = False) -> None:
        """Writes the page of ``vn100 report``: one HTML file that needs nothing else.

        ``span`` is the time in seconds over which a filter integrates. Raises
        :exc:`FileExistsError` for a file that exists, unless it may be overwritten.
        """
        page = self._source().page(span)
        with open(path, "wb" if overwrite else "xb") as file:
            file.write(page)

    def export(self, consumer: str, *, span: float = 60.0, scale_factor: float | None = None) -> str:
        """The text of the file in which a program takes N and K: ``"kalibr"``, ``"openvins"``,
        ``"gtsam"``, ``"lio-sam"`` and others, as ``vn100 report --to`` has them.

        A value that is only bounded stands as its bound, with a comment. ``span`` is the time
        in seconds over which the filter integrates, ``scale_factor`` the error of the scale
        factor in ppm, which some programs need. Raises :exc:`ValueError` for another name, and
        if a value is not known, with what would give it.
        """
        return self._source().filter_file(consumer, span, scale_factor)

    def _source(self) -> _vn100.Measured:
        if self._measured is None:
            raise ValueError("a result that was pickled has no report and no export: write them where it was measured")
        return self._measured

    def __repr__(self) -> str:
        rate = "an unknown rate" if self.rate is None else f"{self.rate:g} Hz"
        return f"<vn100.Result {self.name}: {self.samples} samples at {rate}, {len(self)} channels>"

    def plot(self, *names: str) -> Figure:
        """Draws the curves of these channels, of all by default, with their intervals and
        models: a figure of matplotlib that has axes of its own for each unit. Raises
        :exc:`ValueError` without a channel."""
        units: dict[str, list[str]] = {}
        for name in names or self:
            units.setdefault(self[name].unit, []).append(name)
        if not units:
            raise ValueError("the result has no channel to draw")
        figure = _figure(len(units))
        for ax, drawn in zip(figure.axes, units.values(), strict=True):
            for name in drawn:
                self[name].curve.plot(ax, label=name)
        return figure

    def _repr_html_(self) -> str:
        def row(channel: Channel) -> str:
            terms = (_text(channel.noise, term) for term in ("white", "bias_instability", "rate_random_walk"))
            cells = "".join(f"<td style='white-space:nowrap'>{html.escape(text)}</td>" for text in terms)
            return f"<tr><td>{html.escape(channel.name)}</td>{cells}</tr>"

        title = html.escape(repr(self).strip("<>"))
        error = f"<p><b>{html.escape(self.error)}</b></p>" if self.error else ""
        head = "".join(f"<th>{name}</th>" for name in ("channel", "N", "B", "K"))
        rows = "".join(row(channel) for channel in self.values())
        notes = "".join(f"<li><b>{warning.severity}</b>: {html.escape(warning.text)}</li>" for warning in self.warnings)
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
