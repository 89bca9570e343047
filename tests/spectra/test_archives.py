"""The shipped archives hold what their sources say, faults flagged."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from skinviz import ArgumentError, load_archive
from skinviz.spectra.archives import ARCHIVES


@pytest.fixture(scope="module")
def issa():
    """The International Skin Spectra Archive's part."""
    return load_archive("issa")


@pytest.fixture(scope="module")
def nist():
    """NIST's inner forearms."""
    return load_archive("nist")


def test_issa_has_all_spectra_people_and_sites(issa):
    assert dict(issa.reflectance.sizes) == {"record": 8307, "wavelength": 39}
    assert_array_equal(issa.wavelength, np.arange(360, 741, 10))
    people = set(zip(issa.origin.values, issa.subject.values, strict=True))
    assert len(people) == 1058
    assert np.unique(issa.site).size == 12
    assert np.unique(issa.record).size == 8307


def test_the_papers_four_sites_have_3476_spectra(issa):
    sites = ("cheek", "back of hand", "outer arm", "inner arm")
    assert np.isin(issa.site, sites).sum() == 3476


def test_issas_duplicates_are_57_pairs_under_two_people(issa):
    flagged = issa.reflectance.values[issa.duplicate.values]
    assert len(flagged) == 114
    rows, counts = np.unique(np.nan_to_num(flagged, nan=-1), axis=0, return_counts=True)
    assert len(rows) == 57
    assert (counts == 2).all()
    people = issa.origin.values + "/" + issa.subject.values
    for row in rows:
        same = (np.nan_to_num(issa.reflectance.values, nan=-1) == row).all(axis=1)
        assert np.unique(people[same]).size == 2


def test_known_duplicates_are_flagged(issa):
    for origin, subject in (("China", "189"), ("China", "190"), ("Iraq", "395")):
        own = (issa.origin.values == origin) & (issa.subject.values == subject)
        assert issa.duplicate.values[own].any()


def test_a_repeat_of_one_person_is_no_duplicate(issa):
    people = issa.origin.values + "/" + issa.subject.values + "/" + issa.site.values
    _, which, counts = np.unique(people, return_inverse=True, return_counts=True)
    repeated = counts[which] > 1
    assert repeated.sum() > 1000
    assert issa.duplicate.values[repeated].mean() < 0.02


def test_two_people_are_recorded_with_two_sexes(issa):
    people = issa.origin.values + "/" + issa.subject.values
    pairs = np.unique(people + "/" + issa.sex.values)
    assert len(pairs) - len(np.unique(people)) == 2


@pytest.mark.parametrize("name", ARCHIVES)
def test_reflectance_is_reflectance(name):
    values = load_archive(name).reflectance.values
    inside = values[np.isfinite(values)]
    assert inside.min() > 0
    assert inside.max() < 1


def test_every_spectrum_covers_the_visible(issa, nist):
    for archive in (issa, nist):
        assert np.isfinite(archive.sel(wavelength=slice(400, 700)).reflectance).all()


def test_nist_has_100_forearms_at_5_nm(nist):
    assert dict(nist.reflectance.sizes) == {"record": 100, "wavelength": 61}
    assert_array_equal(nist.wavelength, np.arange(400, 701, 5))
    assert np.unique(nist.subject).size == 100
    assert set(nist.site.values) == {"inner arm"}
    assert not nist.duplicate.any()


@pytest.mark.parametrize("name", ARCHIVES)
def test_archives_say_whence_they_are_and_how_measured(name):
    attributes = load_archive(name).attrs
    assert attributes["specular"] == "included"
    for key in ("source", "licence", "geometry"):
        assert attributes[key]


@pytest.mark.parametrize("name", ARCHIVES)
def test_both_archives_have_the_same_labels(name):
    labels = {"subject", "origin", "group", "sex", "age_group", "site", "duplicate"}
    archive = load_archive(name)
    assert labels <= set(archive.coords)
    for label in labels:
        assert archive[label].dims == ("record",)


def test_light_from_inside_shows_blood_in_everyone(nist):
    # Haemoglobin's band at 545 nm against its valley at 510 and the red.
    at = nist.reflectance.sel
    assert (at(wavelength=545) < at(wavelength=700)).all()
    assert (at(wavelength=400) < at(wavelength=700)).all()


def test_unknown_archive_lists_the_known():
    with pytest.raises(ArgumentError, match="choose one of: issa, nist"):
        load_archive("tm30")
