"""The people whom figures show, and their fits: each computed once."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.archive_selection import average_repeats
from skinviz.spectra.archives import load_archive
from skinviz.study.paper_tables import choose_subjects
from skinviz.study.people import People, people_at
from skinviz.study.tables import SITES, Method, fit_people

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

WHO = (
    "Subjects A, B and C are people of the archive, chosen by skin colour alone: the "
    "individual typology angle of their inner arm is nearest to everyone's 90 %, 50 % "
    "and 10 % quantile."
)
"""Said wherever they appear."""


@cache
def everyone() -> People:
    """Return the people of the archive who were measured at the paper's sites."""
    return people_at(load_archive("issa"), SITES)


@cache
def subjects() -> dict[str, int]:
    """Return which of them are subjects A, B and C."""
    return choose_subjects(everyone())


@cache
def averaged() -> xarray.Dataset:
    """Return one spectrum of each person and site of the archive."""
    return average_repeats(load_archive("issa"))


@cache
def method(model: str = "two-layer", coefficients: str = "effective") -> Method:
    """Return a model's fits to everyone."""
    return fit_people(everyone(), model, coefficients)


def subject_fit(subject: str, site: str, model: str = "two-layer") -> SkinFit:
    """Return the fit of a subject's spectrum at a site."""
    own = skin_model(model, site=site, specular=everyone().specular)
    return fit_skin(subject_spectrum(subject, site), everyone().wavelengths, own)


def subject_spectrum(subject: str, site: str) -> Array:
    """Return a subject's spectrum (n,) at one of the paper's sites."""
    people = everyone()
    spectra: Array = people.reflectance[subjects()[subject], people.sites.index(site)]
    return spectra


def name_of(subject: str) -> str:
    """Return who a subject is: "China/176 (Chinese, M, 20-29)"."""
    i = subjects()[subject]
    return f"{everyone().names[i]} ({everyone().descriptions[i]})"


def visible(wavelengths: Array) -> NDArray[np.bool_]:
    """Return which bands are 400–700 nm, as in the paper."""
    return (wavelengths >= 400) & (wavelengths <= 700)
