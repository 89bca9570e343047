"""What every test shares: strict floating point and Hypothesis without chance."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
settings.load_profile("ci")


@pytest.fixture
def strict_floats() -> Iterator[None]:
    """Turn every floating-point exception, underflow too, into an error."""
    with np.errstate(all="raise"):
        yield
