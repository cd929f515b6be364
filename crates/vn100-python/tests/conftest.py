"""What the tests share: noise, and captures that ship with the project."""

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
