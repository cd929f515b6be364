"""What the tests share: noise, captures that ship with the project, and the program."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

LOGS = Path(__file__).parents[3] / "replay-logs"


@pytest.fixture
def noise() -> NDArray[np.int64]:
    """Whole counts: white noise, and a walk below it."""
    random = np.random.default_rng(7)
    return np.round(100 * random.standard_normal(5000) + np.cumsum(random.standard_normal(5000))).astype(np.int64)


@pytest.fixture
def log() -> Path:
    """A minute of a sensor at rest."""
    return sorted(LOGS.glob("*.vnymr"))[0]


@pytest.fixture
def program() -> str:
    """The program `vn100`; without it the test is skipped."""
    named = os.environ.get("VN100_PROGRAM")
    if named is None:
        pytest.skip("VN100_PROGRAM names no program to compare with")
    return named


@pytest.fixture
def parts(program: str, log: Path, tmp_path: Path) -> list[Path]:
    """That minute as a recording in four parts."""
    record = [program, "record", "-", "-o", "night.mcap", "--rotate", "80kB"]
    subprocess.run(record, cwd=tmp_path, input=log.read_bytes(), check=True, capture_output=True)
    found = sorted(tmp_path.glob("night.*.mcap"))
    assert len(found) == 4
    return found
