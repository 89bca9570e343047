"""Spectra of known values, as read_spectra gives them, to write and read back."""

import numpy as np
import xarray


def spectra_list(values, labels=None, nm=None, **attributes):
    """Return a list of spectra (record, wavelength) with labels."""
    values = np.atleast_2d(values)
    labels = [f"s{i}" for i in range(len(values))] if labels is None else labels
    nm = 400.0 + 10 * np.arange(values.shape[1]) if nm is None else nm
    return xarray.Dataset(
        {"reflectance": (("record", "wavelength"), values, {"units": "1"})},
        coords={
            "record": np.arange(len(labels)),
            "label": ("record", np.array(labels, dtype=str)),
            "wavelength": ("wavelength", np.asarray(nm, float), {"units": "nm"}),
        },
        attrs=attributes,
    )


def spectra_cube(values, nm=None, **attributes):
    """Return a cube (line, sample, wavelength)."""
    values = np.asarray(values)
    nm = 400.0 + 10 * np.arange(values.shape[-1]) if nm is None else nm
    return xarray.Dataset(
        {"reflectance": (("line", "sample", "wavelength"), values, {"units": "1"})},
        coords={"wavelength": ("wavelength", np.asarray(nm, float), {"units": "nm"})},
        attrs=attributes,
    )


def skin_like(*shape, seed=0, dtype=np.float64):
    """Return reflectance between 0.1 and 0.7 with no round digits."""
    return np.random.default_rng(seed).uniform(0.1, 0.7, shape).astype(dtype)
