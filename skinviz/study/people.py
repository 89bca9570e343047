"""People of an archive who were measured at all sites that a study needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_spectra, as_wavelengths
from skinviz.errors import ArgumentError
from skinviz.spectra.archive_selection import average_repeats, people, select
from skinviz.spectra.colorimetry import xyz_to_lab, xyz_weights
from skinviz.spectra.illuminants import illuminant_spd

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class People:
    """People measured at the same sites, one spectrum for each.

    Attributes
    ----------
    names : tuple of str
        One a person, as "China/186".
    descriptions : tuple of str
        Group, sex and age group of each, as far as recorded.
    sites : tuple of str
        The body sites.
    wavelengths : (n,) ndarray
        [nm]
    reflectance : (people, sites, n) ndarray
        NaN in a band that was not measured. [1]
    specular : str or float
        How the surface reflection was measured.
    source : str
        Where the spectra are from.
    """

    names: tuple[str, ...]
    descriptions: tuple[str, ...]
    sites: tuple[str, ...]
    wavelengths: Array
    reflectance: Array
    specular: str | float
    source: str

    def typology_angle(self, site: str) -> Array:
        """Return each person's individual typology angle (people,) at a site. [°]"""
        if site not in self.sites:
            raise ArgumentError(f"unknown site {site!r}; there is {self.sites}")
        spectra = self.reflectance[:, self.sites.index(site)]
        seen = (self.wavelengths >= 400) & (self.wavelengths <= 700)
        return typology_angle(spectra[:, seen], self.wavelengths[seen])


def people_at(archive: xarray.Dataset, sites: Sequence[str]) -> People:
    """Return the people that an archive has at every one of the sites.

    Repeats are averaged and duplicates left out, so that each person has one
    spectrum for each site.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive`.
    sites : sequence of str
        Body sites.

    Returns
    -------
    people : People
        In the order of the archive.

    Raises
    ------
    ArgumentError
        If the archive lacks a site, or has nobody with all of them.
    """
    averaged = select(average_repeats(archive), site=sites)
    names = people(averaged)
    keys = zip(names.tolist(), averaged["site"].values, strict=True)
    places = {key: i for i, key in enumerate(keys)}
    whole = [
        name
        for name in dict.fromkeys(names.tolist())
        if all((name, site) in places for site in sites)
    ]
    if not whole:
        raise ArgumentError(f"nobody was measured at all of {', '.join(sites)}")
    rows = np.array([[places[name, site] for site in sites] for name in whole])
    labels = [averaged[key].values for key in ("group", "sex", "age_group")]
    return People(
        names=tuple(whole),
        descriptions=tuple(
            ", ".join(str(own[row]) for own in labels if own[row]) for row in rows[:, 0]
        ),
        sites=tuple(sites),
        wavelengths=averaged["wavelength"].values,
        reflectance=averaged["reflectance"].values[rows],
        specular=archive.attrs["specular"],
        source=str(archive.attrs["source"]),
    )


def typology_angle(reflectance: ArrayLike, wavelengths: ArrayLike) -> Array:
    """Return the individual typology angle of skin, high for light skin.

    Parameters
    ----------
    reflectance : (..., n) array_like
        [1]
    wavelengths : (n,) array_like
        [nm]

    Returns
    -------
    angle : (...) ndarray of float64
        ITA = arctan((L* − 50)/b*), under D65, 2° observer. [°], −90 to 90 for b* > 0

    References
    ----------
    .. [1] Chardon, Cretois & Hourseau, Int. J. Cosmet. Sci. 13:191 (1991).
    """
    bands = as_wavelengths(wavelengths)
    spectra = as_spectra(reflectance, bands.size, "reflectance")
    weights = xyz_weights(bands, illuminant_spd("D65", bands))
    lab = xyz_to_lab(spectra @ weights, weights.sum(axis=0))
    return np.degrees(np.arctan2(lab[..., 0] - 50, lab[..., 2]))


def at_quantiles(values: ArrayLike, quantiles: Sequence[float]) -> list[int]:
    """Return the index of the value nearest to each quantile; the first of equals."""
    own = np.asarray(values, dtype=np.float64)
    wanted = np.quantile(own, quantiles)
    return [int(np.argmin(np.abs(own - value))) for value in wanted]
