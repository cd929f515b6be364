"""The comparison of what a filter can be given, in a small form."""

import runpy
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

SCRIPT = Path(__file__).parents[3] / "tests" / "inflation.py"


def test_the_filter_is_consistent_with_exact_noise_and_too_sure_with_half_of_it() -> None:
    script = runpy.run_path(str(SCRIPT))
    sensor = {name: terms | {"B": 0.0} for name, terms in script["SENSOR"].items()}
    exact = np.array([terms[term] for terms in sensor.values() for term in "NK"])
    plain, *_ = next(script["compared"](sensor, {"exact": exact, "half": exact / 2}, 20, 200, 1))
    # over seeds the means are 1.00 and 1.55, with standard deviations of 0.04 and 0.08
    found, of_half = plain.mean(0)
    assert abs(found - 1) < 0.2 and of_half > 1.2


def test_the_script_ends_with_its_figure(tmp_path: Path) -> None:
    svg = tmp_path / "inflation.svg"
    small = ["--drives", "3", "--seconds", "120", "--hours", "0.5", "--svg", str(svg)]
    run = subprocess.run([sys.executable, str(SCRIPT), *small], check=True, capture_output=True, text=True)
    assert run.stdout.count("too sure") == 8
    lines = ElementTree.parse(svg).getroot().findall("{http://www.w3.org/2000/svg}polyline")
    assert len(lines) == 8
