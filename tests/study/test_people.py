"""People with all sites: who they are, how light, who stands at a quantile."""

import colour
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from skinviz import ArgumentError, load_archive
from skinviz.spectra.archive_selection import people as names_of
from skinviz.study.people import at_quantiles, people_at, typology_angle

SITES = ("cheek", "back of hand", "outer arm", "inner arm")


@pytest.fixture(scope="module")
def issa():
    return load_archive("issa")


@pytest.fixture(scope="module")
def people(issa):
    return people_at(issa, SITES)


def test_everyone_has_all_sites_once_and_no_duplicate(issa, people):
    assert people.reflectance.shape == (598, 4, 39)
    assert len(set(people.names)) == 598
    doubtful = set(names_of(issa)[issa.duplicate.values])
    whole = {
        name
        for name in doubtful & set(people.names)
        if not issa.duplicate.values[names_of(issa) == name].all()
    }
    assert doubtful & set(people.names) == whole
    assert people.specular == "included"


def test_spectra_are_the_means_of_the_archives(issa, people):
    i = people.names.index("UK/1")
    for s, site in enumerate(SITES):
        own = (names_of(issa) == "UK/1") & (issa.site.values == site)
        expected = issa.reflectance.values[own].mean(axis=0)
        assert_allclose(people.reflectance[i, s], expected, rtol=1e-15)
    assert people.descriptions[i] == "Caucasian, F"


def test_a_site_that_nobody_has_beside_another_is_said(issa):
    with pytest.raises(ArgumentError, match="unknown site 'knee'"):
        people_at(issa, ("cheek", "knee"))
    spain = issa.isel(record=issa.origin.values == "Spain")
    both = (spain.site.values == "cheek") == (spain.subject.values == "1350")
    with pytest.raises(
        ArgumentError, match="nobody was measured at all of cheek, fore"
    ):
        people_at(spain.isel(record=both), ("cheek", "forehead"))


def test_the_typology_angle_agrees_with_colour_science(people):
    seen = (people.wavelengths >= 400) & (people.wavelengths <= 700)
    nm = people.wavelengths[seen]
    shape = colour.SpectralShape(400, 700, 10)
    light = colour.SDS_ILLUMINANTS["D65"].copy().align(shape)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    white = colour.SpectralDistribution(dict.fromkeys(nm, 1.0))
    for i in (0, 200, 590):
        spectrum = people.reflectance[i, 3, seen]
        sd = colour.SpectralDistribution(dict(zip(nm, spectrum, strict=True)))
        xyz, xyz_white = (
            colour.sd_to_XYZ(s, cmfs, light, method="Integration") for s in (sd, white)
        )
        lab = colour.XYZ_to_Lab(xyz / xyz_white[1], colour.XYZ_to_xy(xyz_white))
        expected = np.degrees(np.arctan((lab[0] - 50) / lab[2]))
        assert_allclose(typology_angle(spectrum, nm), expected, atol=0.01)


def test_the_typology_angle_is_lower_for_darker_skin(people):
    seen = (people.wavelengths >= 400) & (people.wavelengths <= 700)
    spectra = people.reflectance[:, 0, seen]
    light = typology_angle(spectra, people.wavelengths[seen])
    dark = typology_angle(spectra * 0.7, people.wavelengths[seen])
    assert (dark < light).all()
    assert_array_equal(people.typology_angle("cheek"), light)
    with pytest.raises(ArgumentError, match="unknown site 'palm'"):
        people.typology_angle("palm")


def test_quantiles_pick_the_nearest_and_the_first_of_equals():
    assert at_quantiles([5.0, 1.0, 3.0, 2.0, 4.0], (0, 0.5, 1)) == [1, 2, 0]
    assert at_quantiles([2.0, 2.0, 2.0], (0.1, 0.9)) == [0, 0]
