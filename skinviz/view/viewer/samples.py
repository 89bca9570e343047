"""Whose skin can be shown: measured people and their fits."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import DataError
from skinviz.scene.scene import Skin
from skinviz.scene.scene_skin import archive_records
from skinviz.skin.fit import fit_skin
from skinviz.skin.model import SkinModel
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.archive_selection import people
from skinviz.study.study import Study

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

ANY_GROUP = ""
"""The group of all people."""


@dataclass(frozen=True, eq=False)
class Sample:
    """Skin that can be shown, with what is known of it.

    Attributes
    ----------
    name : str
        For people to read.
    skin : Skin
        The model and its parameters.
    fit : SkinFit or None
        Where they were fitted here.
    measured : (n,) ndarray or None
        The spectrum, on the fit's wavelengths. [1]
    interval : (p, 2) ndarray or None
        Of the parameters, 95 %, where it is known.
    table : dict
        What a scene file's ``[skin]`` says of it.
    """

    name: str
    skin: Skin
    fit: SkinFit | None
    measured: Array | None
    interval: Array | None
    table: dict[str, Any]


class Samples(Protocol):
    """Measured people, to choose from."""

    def groups(self) -> list[str]:
        """Return the groups of people that there are."""
        ...

    def people(self, group: str) -> list[str]:
        """Return the people of a group, or of all."""
        ...

    def sites(self, person: str) -> list[str]:
        """Return where a person was measured."""
        ...

    def sample(self, person: str, site: str) -> Sample:
        """Return a person's skin at a site."""
        ...


@dataclass(frozen=True, eq=False)
class ArchiveSamples:
    """The people of an archive.

    Attributes
    ----------
    name : str
        Of the archive.
    archive : xarray.Dataset
        From :func:`load_archive`.
    options : dict
        What a scene file's ``[skin]`` says of the model.
    """

    name: str
    archive: xarray.Dataset
    options: dict[str, Any]

    @cached_property
    def _people(self) -> NDArray[np.str_]:
        """The person of each record."""
        return people(self.archive)

    def groups(self) -> list[str]:
        """Return the groups of people that there are."""
        return sorted({str(group) for group in self.archive["group"].values if group})

    def people(self, group: str) -> list[str]:
        """Return the people of a group, or of all, in the archive's order."""
        names = self._people
        if group != ANY_GROUP:
            names = names[self.archive["group"].values == group]
        return [str(name) for name in dict.fromkeys(names.tolist())]

    def sites(self, person: str) -> list[str]:
        """Return where a person was measured."""
        own = self._people == person
        return sorted({str(site) for site in self.archive["site"].values[own]})

    def sample(self, person: str, site: str) -> Sample:
        """Fit a person's spectrum at a site.

        Raises
        ------
        SkinvizError
            If there is none, or it cannot be fitted.
        """
        origin, _, subject = person.rpartition("/")
        who = {"origin": origin, "subject": subject, "site": site}
        records = archive_records(self.archive, self.name, who)
        spectrum = self.archive.reflectance.values[records].mean(axis=0)
        options = {key: self.options[key] for key in _MODEL if key in self.options}
        if "thickness" not in options:
            options["site"] = site
        specular = self.options.get("specular", self.archive.attrs["specular"])
        name = self.options.get("model", "two-layer")
        model = skin_model(name, specular=specular, **options)
        table = {**self.options, "archive": self.name, **who}
        wavelengths = self.archive.wavelength.values
        return _fitted(f"{person} {site}", spectrum, wavelengths, model, table)


@dataclass(frozen=True, eq=False)
class StudySamples:
    """The subjects of a study; conditions are told with the site.

    Attributes
    ----------
    study : Study
        From :func:`skinviz.study.study_file.read_study`.
    """

    study: Study

    def groups(self) -> list[str]:
        """Return the groups of subjects that there are."""
        return sorted({group for group in self.study.levels("group") if group})

    def people(self, group: str) -> list[str]:
        """Return the subjects of a group, or all."""
        if group == ANY_GROUP:
            return list(self.study.levels("subject"))
        own = self.study.spectra["group"].values == group
        subjects = self.study.spectra["subject"].values[own]
        return [str(name) for name in dict.fromkeys(subjects.tolist())]

    def sites(self, person: str) -> list[str]:
        """Return where, and in which conditions, a subject was measured."""
        own = self.study.spectra["subject"].values == person
        return list(dict.fromkeys(self._places[own].tolist()))

    def sample(self, person: str, site: str) -> Sample:
        """Fit the mean of a subject's repeats at a site.

        Raises
        ------
        SkinvizError
            If there is none, or it cannot be fitted.
        """
        spectra = self.study.spectra
        own = (spectra["subject"].values == person) & (self._places == site)
        if not own.any():
            raise DataError(
                f"the study has no spectrum of {person!r} at {site!r}; there are "
                f"{', '.join(self.sites(person)) or 'none of this subject'}"
            )
        some = spectra.reflectance.isel(record=np.flatnonzero(own))
        thickness = self.study.layers[str(some["site"].values[0])]
        model = skin_model(specular=self.study.specular, thickness=thickness)
        spectrum = some.mean("record").values
        wavelengths = spectra.wavelength.values
        found = _fitted(f"{person} {site}", spectrum, wavelengths, model, {})
        return dataclasses.replace(found, table=weights_table(found.skin))

    @cached_property
    def _places(self) -> NDArray[Any]:
        """Site and condition of each record."""
        names = [
            f"{site}, {condition}" if condition else str(site)
            for site, condition in zip(
                self.study.spectra["site"].values,
                self.study.spectra["condition"].values,
                strict=True,
            )
        ]
        return np.array(names, dtype=object)


_MODEL = ("thickness", "coefficients", "free")


def weights_table(skin: Skin) -> dict[str, Any]:
    """Return what a scene file's ``[skin]`` says of uniform skin, by its weights."""
    model = skin.model
    return {
        "weights": skin.values.tolist(),
        "model": model.name,
        "specular": model.specular,
        "thickness": list(model.thickness),
        "coefficients": model.coefficients.name,
    }


def _fitted(
    name: str,
    spectrum: Array,
    wavelengths: Array,
    model: SkinModel,
    table: dict[str, Any],
) -> Sample:
    """Return a measured spectrum with its fit."""
    fit = fit_skin(spectrum, wavelengths, model)
    inside = np.isin(wavelengths, fit.wavelengths)
    skin = Skin.from_fit(fit)
    return Sample(name, skin, fit, spectrum[inside], fit.interval, table)
