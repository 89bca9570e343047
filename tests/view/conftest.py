"""Real spectra and their fits, and pictures that need no drawing."""

import numpy as np
import pytest

from meshes import sphere
from skinviz import (
    Camera,
    DirectionalLight,
    Scene,
    Skin,
    TorranceSparrow,
    fit_skin,
    load_archive,
    skin_model,
)
from skinviz.rendering.plan import Plan
from skinviz.rendering.render import render
from skinviz.view.figures import Site


@pytest.fixture(scope="session")
def archive():
    return load_archive("issa")


def make_site(archive, origin, subject, name):
    chosen = (
        (archive.origin == origin)
        & (archive.subject == subject)
        & (archive.site == name)
    ).values
    spectrum = archive.reflectance.values[chosen].mean(axis=0)
    model = skin_model(site=name, specular=archive.attrs["specular"])
    fit = fit_skin(spectrum, archive.wavelength.values, model)
    inside = archive.wavelength.isin(fit.wavelengths).values
    return Site(name, spectrum[inside], fit)


@pytest.fixture(scope="session")
def sites(archive):
    """Four body sites of one person."""
    names = ("back of hand", "cheek", "outer arm", "inner arm")
    return [make_site(archive, "China", "186", name) for name in names]


@pytest.fixture(scope="session")
def darkest(archive):
    """The site whose mean reflectance is the lowest of the archive's cheeks."""
    bands = archive.reflectance.sel(wavelength=slice(400, 700)).values
    level = np.where(archive.site.values == "cheek", bands.mean(axis=1), np.inf)
    record = archive.isel(record=int(np.nanargmin(level)))
    return make_site(archive, record.origin.item(), record.subject.item(), "cheek")


@pytest.fixture(scope="session")
def scene(sites):
    return Scene(
        mesh=sphere(40, 3),
        skin=Skin.from_fit(sites[0].fit),
        surface=TorranceSparrow(),
        lights=(DirectionalLight([0, 0, 1]),),
        camera=Camera([0, 0, 1], [0, 1, 0], (84, 110)),
    )


@pytest.fixture(scope="session")
def picture(scene):
    """The scene traced, 84 by 110 pixels."""
    return render(scene, Plan(samples=1))
