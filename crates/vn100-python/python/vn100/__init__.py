"""Noise of inertial sensors from captures and arrays: Allan deviation with
intervals, N, B and K with a status, spectra, warnings.

Sums are exact integers: the same samples give the same bits, however they were
divided. The document of a result (``to_dict``) is that of ``vn100 replay --json``.
"""

from importlib.metadata import version as _version

from ._analyzer import Analyzer
from ._deviations import adev, gradev, hdev, mdev, oadev, ohdev, totdev
from ._replay import Results, replay
from ._result import Channel, Curve, Noise, Parameter, Result, ResultWarning
from ._rows import Rows, captures, rows
from ._simulated import Simulated, simulate
from ._vn100 import CaptureError, archive_rows

__version__ = _version("vn100")

__all__ = [
    "Analyzer",
    "CaptureError",
    "Channel",
    "Curve",
    "Noise",
    "Parameter",
    "Result",
    "ResultWarning",
    "Results",
    "Rows",
    "Simulated",
    "adev",
    "archive_rows",
    "captures",
    "gradev",
    "hdev",
    "mdev",
    "oadev",
    "ohdev",
    "replay",
    "rows",
    "simulate",
    "totdev",
]
