"""The archive and real fits, read and made once for this folder."""

import numpy as np
import pytest

from skinviz import fit_skin, load_archive, skin_model
from skinviz.skin.coefficients import body_sites


@pytest.fixture(scope="session")
def issa():
    """The shipped ISSA spectra."""
    return load_archive("issa")


@pytest.fixture(scope="session")
def site_fits(issa):
    """A SkinFit of all shipped spectra of each of the paper's four sites."""
    nm = issa.wavelength.values
    return {
        site: fit_skin(
            issa.reflectance.values[np.flatnonzero(issa.site.values == site)],
            nm,
            skin_model(site=site, specular="included"),
        )
        for site in body_sites()
    }
