"""Floating point for surfaces: strict, but a lobe's far tail may underflow to 0."""

from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture
def strict_floats() -> Iterator[None]:
    """Turn overflow, division by 0 and invalid operations into errors."""
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        yield
