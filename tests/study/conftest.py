"""A study's folder, and people of the archive with their fits."""

import dataclasses

import numpy as np
import pytest
from study_folders import skin, write_table
from study_people import part

from skinviz import load_archive
from skinviz.study.people import people_at
from skinviz.study.tables import COEFFICIENTS, SITES, fit_people


@pytest.fixture
def folder(tmp_path):
    """Three people at two sites in two conditions, one file a record."""
    rng = np.random.default_rng(3)
    for subject in "ABC":
        for site in ("cheek", "inner arm"):
            for condition, oxy in (("before", 0.006), ("after", 0.009)):
                own = np.array([0.1, oxy, 0.003]) * rng.uniform(0.9, 1.1, 3)
                name = f"{subject}_{site.replace(' ', '-')}_{condition}.csv"
                write_table(tmp_path / "spectra" / name, skin(own, site), [name])
    (tmp_path / "study.toml").write_text(
        'title = "three"\nspecular = "included"\n'
        'pattern = "spectra/{subject}_{site}_{condition}.csv"\n',
        "utf-8",
    )
    return tmp_path


@pytest.fixture(scope="session")
def everyone():
    return people_at(load_archive("issa"), SITES)


@pytest.fixture(scope="session")
def seven(everyone):
    return part(everyone, list(range(0, 598, 90)))


@pytest.fixture(scope="session")
def methods(seven):
    own = [fit_people(seven, "two-layer", name) for name in COEFFICIENTS]
    worse = [
        dataclasses.replace(m, model="worse", sse_61=m.sse_61 * 2, status=m.status)
        for m in own
    ]
    return [own[0], worse[0], own[1], worse[1]]
