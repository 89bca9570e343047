"""Files of spectra of skin whose weights are known."""

import numpy as np
import xarray as xr

from skinviz import skin_model, write_spectra

BANDS = np.arange(400.0, 701.0, 10.0)


def write_table(path, spectra, labels, bands=BANDS):
    """Write spectra with labels as the suffix says."""
    table = xr.Dataset(
        {"reflectance": (("record", "wavelength"), np.atleast_2d(spectra))},
        coords={"wavelength": bands, "label": ("record", np.array(labels))},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_spectra(path, table)


def skin(weights, site="cheek", bands=BANDS):
    """Return what is measured of skin with these weights."""
    return skin_model(site=site, specular="included").measured(weights, bands)
