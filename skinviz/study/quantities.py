"""What a comparison compares: numbers of each record, from its spectrum and fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.fit import fit_skin
from skinviz.skin.model import SkinModel
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import NOT_CONVERGED, REFUSED, SkinFit
from skinviz.spectra.colorimetry import spectrum_to_xyz, xyz_to_lab
from skinviz.study.study import Study

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """A number that each record has.

    Attributes
    ----------
    name, unit, words : str
        In tables, its unit ("1" of a pure number), and what it is.
    """

    name: str
    unit: str
    words: str


_WORDS = {
    "w_m": "melanin weight",
    "w_h": "oxyhaemoglobin weight",
    "w_dh": "deoxyhaemoglobin weight",
}

_DERIVED = (
    Quantity("w_m_depth", "mm", "melanin times its layer, w_m·D_e"),
    Quantity("blood_fraction", "1", "blood, w_h + w_dh"),
    Quantity("oxygen_saturation", "1", "saturation, w_h/(w_h + w_dh)"),
    Quantity("L*", "1", "L* under D65, 2° observer"),
    Quantity("a*", "1", "a* under D65, 2° observer"),
    Quantity("b*", "1", "b* under D65, 2° observer"),
    Quantity("ITA", "°", "individual typology angle"),
)


@dataclass(frozen=True, eq=False)
class Measured:
    """The numbers of a study's records.

    Attributes
    ----------
    models : dict of str to SkinModel
        What was fitted at each site.
    quantities : tuple of Quantity
        The model's parameters, and what follows.
    values : (records, q) ndarray
        NaN of a record that was not fitted, or where there is none.
    failed : (records,) ndarray of bool
        Whether the fit was refused or did not converge.
    """

    models: dict[str, SkinModel]
    quantities: tuple[Quantity, ...]
    values: Array
    failed: NDArray[np.bool_]

    def less(self, name: str) -> Measured:
        """Return the numbers without one quantity."""
        kept = [i for i, own in enumerate(self.quantities) if own.name != name]
        quantities = tuple(self.quantities[i] for i in kept)
        return replace(self, quantities=quantities, values=self.values[:, kept])


def measure(
    study: Study,
    *,
    model: str = "two-layer",
    coefficients: str = "effective",
    advance: Callable[[int], object] | None = None,
) -> Measured:
    """Return what the records of a study amount to, each site with its own layers.

    Parameters
    ----------
    study : Study
        At least one record.
    model, coefficients : str
        As for :func:`skin_model`.
    advance : callable, optional
        Told the number of spectra of each part that is done.
    """
    models = {
        site: skin_model(
            model,
            specular=study.specular,
            thickness=layers,
            coefficients=coefficients,
        )
        for site, layers in study.layers.items()
    }
    first = next(iter(models.values()))
    quantities = (
        *(
            Quantity(p.name, p.unit, _WORDS.get(p.name, p.name))
            for p in first.parameters
        ),
        *_DERIVED,
    )
    sites = study.spectra["site"].values
    bands = study.spectra["wavelength"].values
    spectra = study.spectra["reflectance"].values
    values = np.full((sites.size, len(quantities)), np.nan)
    failed = np.zeros(sites.size, dtype=np.bool_)
    for site, own in models.items():
        rows = np.flatnonzero(sites == site)
        if rows.size:
            fit = fit_skin(spectra[rows], bands, own, advance=advance)
            failed[rows] = np.isin(fit.status, (REFUSED, NOT_CONVERGED))
            values[rows] = _values(fit, study.layers[site][0])
    values[failed] = np.nan
    return Measured(models, quantities, values, failed)


def measured_lab(fit: SkinFit) -> Array:
    """Return L*a*b* (..., 3) of what was measured, under D65 and the 2° observer."""
    white = spectrum_to_xyz(np.ones(fit.wavelengths.size), fit.wavelengths)
    return xyz_to_lab(fit.xyz[..., 0, :], white)


def _values(fit: SkinFit, epidermis: float) -> Array:
    """Return the quantities (m, q) of fits."""
    lab = measured_lab(fit)
    melanin = fit.values[:, fit.parameters.index("w_m")]
    columns = [
        melanin * epidermis,
        fit.blood_fraction,
        fit.oxygen_saturation,
        *lab.T,
        np.degrees(np.arctan2(lab[:, 0] - 50, lab[:, 2])),
    ]
    return np.column_stack([fit.values, *columns])
