"""The skin of a scene file: weights given, read from a fit file, or fitted now."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinviz._files import existing_file
from skinviz.errors import DataError
from skinviz.scene.scene import Skin
from skinviz.skin.fit import fit_skin
from skinviz.skin.fitted import FITS_FORMAT
from skinviz.skin.models import skin_model
from skinviz.skin.report import FIT_FORMAT
from skinviz.spectra.archives import load_archive

if TYPE_CHECKING:
    import xarray

_TISSUE = {"site", "thickness", "coefficients", "free"}
_SKIN_KEYS = {
    "weights": {"model", "specular"} | _TISSUE,
    "fit": {"record"},
    "archive": {"model", "specular", "origin", "subject"} | _TISSUE,
}


def skin_of(table: dict[str, Any], folder: Path) -> Skin:
    """Return the skin: weights given, read from a fit file, or fitted now."""
    sources = [key for key in _SKIN_KEYS if key in table]
    if len(sources) != 1:
        raise DataError(
            "[skin] needs exactly one of weights = [w_m, w_h, w_dh], "
            f'fit = "fit.json" and archive = "issa"; got {sources or "none"}'
        )
    (source,) = sources
    idle = sorted(table.keys() - _SKIN_KEYS[source] - {source})
    if idle:
        raise DataError(f"[skin] with {source} has no use for {', '.join(idle)}")
    if source == "fit":
        return skin_from_fit_file(folder / table["fit"], table.get("record", 0))
    options = {key: table[key] for key in _TISSUE if key in table}
    if str(options.get("coefficients")).lower().endswith(".csv"):
        options["coefficients"] = folder / options["coefficients"]
    name = table.get("model", "two-layer")
    if source == "archive":
        return _archive_skin(table, name, options)
    if "specular" not in table:
        raise DataError(
            '[skin] needs specular = "excluded", "included" or a number: how the '
            "spectrum behind the weights was measured"
        )
    model = skin_model(name, specular=table["specular"], **options)
    return Skin(model, np.asarray(table["weights"], dtype=np.float64))


def _archive_skin(table: dict[str, Any], name: str, options: dict[str, Any]) -> Skin:
    """Fit the spectrum of one archive subject and site."""
    for key in ("origin", "subject", "site"):
        if key not in table:
            raise DataError(f"[skin] with archive needs {key} = ...")
    measured = archive_spectrum(
        load_archive(table["archive"]),
        table["archive"],
        {key: str(table[key]) for key in ("origin", "subject", "site")},
    )
    if "thickness" in options:  # then the site only names the spectrum
        options = {key: options[key] for key in options if key != "site"}
    specular = table.get("specular", measured.attrs["specular"])
    model = skin_model(name, specular=specular, **options)
    return Skin.from_fit(fit_skin(measured.values, measured.wavelength.values, model))


def archive_spectrum(
    archive: xarray.Dataset, name: str, who: dict[str, str]
) -> xarray.DataArray:
    """Return the mean spectrum (wavelength,) of one subject and site of an archive.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive`.
    name : str
        Its name, for messages.
    who : dict of str to str
        ``origin``, ``subject`` and ``site``.

    Raises
    ------
    DataError
        If it has no such spectrum.
    """
    chosen = np.ones(archive.sizes["record"], dtype=bool)
    for key, value in who.items():
        chosen &= archive[key].values == value
    if not chosen.any():
        sites = sorted(set(archive["site"].values))
        raise DataError(
            f"archive {name!r} has no spectrum of subject "
            f"{who['subject']!r} of {who['origin']!r} at {who['site']!r}; its "
            f"sites are {', '.join(sites)}, its origins "
            f"{', '.join(sorted(set(archive['origin'].values)))}"
        )
    own: xarray.DataArray = archive.reflectance.isel(record=np.flatnonzero(chosen))
    return own.mean("record", skipna=False).assign_attrs(archive.attrs)


def skin_from_fit_file(path: Path, record: int = 0) -> Skin:
    """Return the skin in a JSON file that ``skinviz fit`` wrote."""
    file = existing_file(path, DataError)
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        known = content["format"] == FIT_FORMAT
        if content["format"] == FITS_FORMAT:
            raise DataError(
                f"{file} holds fits of several models; fit with one --model for a scene"
            )
        fits = content["fits"]
        options = {key: content[key] for key in ("specular", "coefficients")}
        options |= {key: content[key] for key in ("free",) if key in content}
        name, thickness = content["model"], content["thickness_mm"]
        backing = content["hypodermis"]
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(f"{file}: not a fit file of 'skinviz fit'") from error
    if not known:
        raise DataError(f"{file}: written as {content['format']!r}; fit the file anew")
    if record >= len(fits):
        raise DataError(f"{file} has {len(fits)} records, 0 the first; got {record}")
    model = skin_model(name, thickness=thickness, hypodermis=backing, **options)
    weights = fits[record]["parameters"]
    values = [weights[p.name]["value"] for p in model.parameters]
    if any(value is None for value in values):
        raise DataError(
            f"{file}: record {record} was refused by the fit; choose another"
        )
    return Skin(model, np.asarray(values, dtype=np.float64))
