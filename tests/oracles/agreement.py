"""How a result is compared with an oracle's, over all magnitudes of floats."""

import numpy as np
from numpy.testing import assert_allclose
from tolerances import NORMAL, ORACLE


def assert_oracle(actual, expected, rtol=ORACLE):
    """Demand relative agreement where the expected value is a normal float.

    Below that a float has no digits left to compare: the result must be as small.
    """
    actual, expected = np.asarray(actual), np.asarray(expected)
    assert actual.shape == expected.shape
    normal = np.abs(expected) >= NORMAL
    with np.errstate(under="ignore"):
        assert_allclose(actual[normal], expected[normal], rtol=rtol, atol=0)
    assert (np.abs(actual[~normal]) <= NORMAL).all()
