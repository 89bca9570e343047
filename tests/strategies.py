"""Hypothesis strategies and seeded draws: physical ranges, extremes in them."""

from math import log10

import numpy as np
from hypothesis import strategies as st

SMALLEST, LARGEST = 1e-16, 1e16


def log_uniform(low: float, high: float) -> st.SearchStrategy[float]:
    """Floats whose logarithm is spread evenly from low to high, both included."""
    exponent = st.floats(log10(low), log10(high))
    return exponent.map(lambda e: min(max(10.0**e, low), high))


coefficients = st.one_of(
    st.just(0.0),
    st.sampled_from([SMALLEST, 1.0, LARGEST]),
    log_uniform(SMALLEST, LARGEST),
)
"""K or S over the declared range. [mm⁻¹]"""

depths = st.one_of(coefficients, st.just(float("inf")))
"""Thickness over the declared range. [mm]"""

lab_colours = st.tuples(
    st.floats(0, 100),
    st.sampled_from([0.0, 10.0, -30.0]) | st.floats(-128, 128),
    st.sampled_from([0.0, -10.0, 30.0]) | st.floats(-128, 128),
)
"""CIELAB, greys and opposite hues among them."""


def drawn(rng: np.random.Generator, n: int, *, infinite: bool = False) -> np.ndarray:
    """Return n values of K, S or (infinite) D: 0, both ends, else log-uniform."""
    values = np.clip(
        10.0 ** rng.uniform(log10(SMALLEST), log10(LARGEST), n), SMALLEST, LARGEST
    )
    extremes = [0.0, 0.0, SMALLEST, LARGEST] + [np.inf] * (3 * infinite)
    chosen = rng.random(n) < 0.04 * len(extremes)
    values[chosen] = rng.choice(extremes, chosen.sum())
    return values
