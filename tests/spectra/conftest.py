"""colour-science, which is the oracle here and warns while it is imported."""

import warnings

import pytest


@pytest.fixture(scope="session")
def colour():
    """The module, with its domain-range scale as it starts: 1."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour
