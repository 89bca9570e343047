"""Grids: straight lines survive resampling, and widths add up to the span."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from tolerances import ROUNDING

from skinviz import ArgumentError
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS, band_widths, resample

steps = st.lists(st.floats(0.1, 30), min_size=1, max_size=20)


def grid(steps, start=400.0):
    """Return ascending wavelengths from their steps."""
    return start + np.concatenate([[0.0], np.cumsum(steps)])


def test_the_papers_wavelengths_are_61():
    assert PAPER_WAVELENGTHS.size == 61
    assert_array_equal(PAPER_WAVELENGTHS[[0, 1, -1]], [400, 405, 700])
    with pytest.raises(ValueError, match="read-only"):
        PAPER_WAVELENGTHS[0] = 0


@given(steps=steps, shares=st.lists(st.floats(0, 1), min_size=1, max_size=9))
def test_straight_lines_survive_resampling(steps, shares):
    old = grid(steps)
    new = np.unique(old[0] + (old[-1] - old[0]) * np.array(shares))
    new = np.clip(new, old[0], old[-1])
    lines = np.stack([2 * old - 7, np.full_like(old, 0.3)])
    expected = np.stack([2 * new - 7, np.full_like(new, 0.3)])
    assert_allclose(resample(lines, old, new), expected, rtol=ROUNDING)


@given(steps=steps)
def test_resampling_to_the_same_grid_changes_nothing(steps):
    old = grid(steps)
    values = np.sin(old)
    assert_array_equal(resample(values, old, old), values)


@given(steps=steps, at=st.floats(0, 1))
def test_resampling_never_overshoots(steps, at):
    old = grid(steps)
    new = np.array([min(old[0] + at * (old[-1] - old[0]), old[-1])])
    values = np.where(np.arange(old.size) % 2, 1.0, 0.0)
    assert 0 <= resample(values, old, new) <= 1


def test_resampling_keeps_the_batch():
    old, new = np.array([400.0, 500, 600]), np.array([450.0, 600])
    values = np.arange(18.0).reshape(2, 3, 3)
    found = resample(values, old, new)
    assert_array_equal(found[1, 2], [15.5, 17])
    assert found.shape == (2, 3, 2)


def test_one_band_stays_as_it_is():
    band = np.array([550.0])
    assert_array_equal(resample(np.array([[0.4]]), band, band), [[0.4]])


@pytest.mark.parametrize("new", [[399.0, 500], [500, 701.0], [800.0], [1.0]])
def test_nothing_is_extrapolated(new):
    old = np.array([400.0, 700.0])
    with pytest.raises(ArgumentError, match=r"^lamp covers 400 to 700 nm; .*"):
        resample(np.ones(2), old, np.array(new), "lamp")


@given(steps=steps)
def test_widths_add_up_to_the_span_and_half_a_band_beyond(steps):
    nm = grid(steps)
    expected = nm[-1] - nm[0] + (steps[0] + steps[-1]) / 2
    assert_allclose(band_widths(nm).sum(), expected, rtol=1e-11)
    assert (band_widths(nm) > 0).all()


def test_equal_bands_have_equal_widths():
    assert_array_equal(band_widths(PAPER_WAVELENGTHS), 5)
    assert_array_equal(band_widths(np.array([632.8])), 1)
