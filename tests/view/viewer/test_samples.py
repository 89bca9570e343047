"""The people to choose from: of an archive, and of a study."""

from pathlib import Path

import numpy as np
import pytest

from skinviz import fit_skin, load_archive, skin_model
from skinviz.errors import SkinvizError
from skinviz.study.study_file import read_study
from skinviz.view.viewer.opened import open_path
from skinviz.view.viewer.pictures import Darkroom
from skinviz.view.viewer.samples import ANY_GROUP, ArchiveSamples
from skinviz.view.viewer.saving import scene_content, toml_text

STUDY = Path(__file__).parents[3] / "docs" / "examples" / "study"


@pytest.fixture(scope="module")
def archive():
    return load_archive("issa")


@pytest.fixture(scope="module")
def people(archive):
    return ArchiveSamples("issa", archive, {})


def test_people_of_a_group_are_some_of_all(people, archive):
    everybody = people.people(ANY_GROUP)
    assert len(everybody) == len(set(everybody)) > 1000
    for group in people.groups():
        own = people.people(group)
        assert 0 < len(own) < len(everybody)
        assert set(own) <= set(everybody)
        name = own[0]
        origin, subject = name.rsplit("/", 1)
        named = (archive.origin == origin) & (archive.subject == subject)
        assert group in archive["group"].values[named.values]


def test_a_sample_is_the_fit_of_the_mean_spectrum(people, archive):
    sample = people.sample("China/186", "cheek")
    named = (archive.origin == "China") & (archive.subject == "186")
    own = named & (archive.site == "cheek")
    mean = archive.reflectance.values[own.values].mean(axis=0)
    model = skin_model(site="cheek", specular=archive.attrs["specular"])
    fit = fit_skin(mean, archive.wavelength.values, model)
    np.testing.assert_array_equal(sample.skin.values, fit.values)
    np.testing.assert_array_equal(sample.interval, fit.interval)
    assert sample.measured.size == fit.wavelengths.size


def test_sites_are_those_that_were_measured(people):
    assert "back of hand" in people.sites("China/186")
    assert people.sites("Nobody/0") == []


@pytest.mark.parametrize(("person", "site"), [("Nobody/0", "cheek"), ("186", "cheek")])
def test_nobody_has_no_skin(people, person, site):
    with pytest.raises(SkinvizError, match="no spectrum"):
        people.sample(person, site)


# Studies -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def study():
    return open_path(STUDY)


def test_a_study_is_opened_with_its_subjects(study):
    read = read_study(STUDY)
    assert study.name == read.title
    assert study.samples.people(ANY_GROUP) == list(read.levels("subject"))
    person = study.samples.people(ANY_GROUP)[-1]
    for site in study.samples.sites(person):
        sample = study.samples.sample(person, site)
        assert sample.skin.model.thickness in read.layers.values()
        assert sample.fit.status in ("converged", "at_bound")
    with pytest.raises(SkinvizError, match="no spectrum"):
        study.samples.sample(person, "nose tip")
    for group in study.samples.groups():
        assert set(study.samples.people(group)) <= set(read.levels("subject"))


def test_a_studys_view_is_saved_with_its_weights(study, tmp_path):
    person = study.samples.people(ANY_GROUP)[1]
    site = study.samples.sites(person)[0]
    state = study.initial.with_look(person=person, site=site)
    shown = Darkroom(study).quick(state, (40, 50))
    file = tmp_path / "again.toml"
    file.write_text(toml_text(scene_content(study, shown)), encoding="utf-8")
    again = open_path(file)
    np.testing.assert_array_equal(
        Darkroom(again).quick(again.initial, (40, 50)).picture, shown.picture
    )
