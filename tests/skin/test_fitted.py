"""Fits as tables: large ones in parts, with the same numbers."""

import numpy as np
import pytest
import xarray
from numpy.testing import assert_array_equal

from skinviz import fit_skin, skin_model
from skinviz.skin import fitted, report
from skinviz.skin.fitted import Fitted, as_dataset
from skinviz.skin.report import blocks, derived, indistinct_counts

NM = np.arange(400.0, 701.0, 10.0)
MODEL = skin_model(site="cheek", specular="included")


@pytest.fixture(scope="module")
def cube():
    """A cube of 6 lines and 5 samples, from light to dark, one pixel missing."""
    rng = np.random.default_rng(3)
    weights = rng.uniform([0.02, 0.003, 0.003], [0.4, 0.01, 0.006], (6, 5, 3))
    values = MODEL.measured(weights, NM) + rng.normal(0, 2e-3, (6, 5, NM.size))
    values[3, 2] = np.nan
    spectra = xarray.Dataset(
        {"reflectance": (("line", "sample", "wavelength"), values)},
        coords={"wavelength": NM},
    )
    return Fitted("cube.hdr", "", spectra, (fit_skin(values, NM, MODEL),))


@pytest.mark.parametrize("most", [1, 7, 11, 29])
def test_parts_together_are_the_whole(cube, most, monkeypatch):
    (fit,) = cube.fits
    whole, pairs = derived(fit), indistinct_counts(fit)
    table = as_dataset([cube], {})
    monkeypatch.setattr(report, "_BLOCK", most)
    parts = list(blocks(fit))
    assert len(parts) > 1
    assert_array_equal(np.concatenate([p.sse for p in parts]), fit.sse)
    for name, values in derived(fit).items():
        assert_array_equal(values, whole[name])
    assert indistinct_counts(fit) == pairs
    xarray.testing.assert_identical(as_dataset([cube], {}), table)


def test_what_cannot_be_told_apart_is_counted_as_the_fit_says(cube):
    (fit,) = cube.fits
    counts = indistinct_counts(fit)
    said = fit.indistinct()
    assert {key: n for key, (n, _) in counts.items()} == {
        key: int(where.sum()) for key, where in said.items()
    }
    for (first, second), (_, trades) in counts.items():
        i, j = (fit.parameters.index(name) for name in (first, second))
        assert trades == (fit.correlation[said[first, second], i, j].sum() < 0)


def test_curves_of_very_many_spectra_are_left_out_and_that_is_said(cube, monkeypatch):
    assert as_dataset([cube], {}).attrs["curves"] == "all"
    monkeypatch.setattr(fitted, "_MOST_WITH_CURVES", 29)
    table = as_dataset([cube], {})
    assert table.attrs["curves"] == "left out of more than 29 spectra"
    assert not {"fitted", "reflectance", "diffuse", "measured"} & set(table.data_vars)
    assert_array_equal(table["value"].to_numpy(), cube.fits[0].values)


def test_one_spectrum_is_a_batch_of_its_own(cube):
    one = cube.fits[0][0, 0]
    assert [part.sse for part in blocks(one)] == [one.sse]
    assert derived(one)["bic"] == one.bic
