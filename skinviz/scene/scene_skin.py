"""The skin of a scene file: weights given, read from a fit file, or fitted now."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz._validate import as_numbers
from skinviz.errors import DataError
from skinviz.scene.painted import painted_image, painted_vertices
from skinviz.scene.scene import Skin
from skinviz.skin.fit import fit_skin
from skinviz.skin.fitted import FITS_FORMAT
from skinviz.skin.model import SkinModel
from skinviz.skin.models import skin_model
from skinviz.skin.report import FIT_FORMAT
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.archives import load_archive

if TYPE_CHECKING:
    import pyvista
    import xarray

_TISSUE = {"site", "thickness", "coefficients", "free"}
_MODEL = {"model", "specular"} | _TISSUE
_SKIN_KEYS = {
    "weights": _MODEL,
    "fit": {"record"},
    "archive": {"origin", "subject"} | _MODEL,
    "painted": _MODEL,
    "image": {"weights_at_one"} | _MODEL,
}
_NO_FIT = "not a fit file of 'skinviz fit'"
_WHO = ("origin", "subject", "site")
_SHOWN = 20  # labels of a file that an error lists
_ELSEWHERE = {"map", "point", "change", "texture"}  # said on top of any skin


def skin_of(table: dict[str, Any], folder: Path, mesh: pyvista.PolyData) -> Skin:
    """Return the skin: weights given or painted, read from a fit file, or fitted."""
    sources = [key for key in _SKIN_KEYS if key in table]
    if len(sources) != 1:
        raise DataError(
            "[skin] needs exactly one of weights = [w_m, w_h, w_dh], "
            f'fit = "fit.json" and archive = "issa"; got {sources or "none"}'
        )
    (source,) = sources
    idle = sorted(table.keys() - _SKIN_KEYS[source] - _ELSEWHERE - {source})
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
    if source == "weights":
        return Skin(model, np.asarray(table["weights"], dtype=np.float64))
    return _painted_skin(table, model, folder, mesh)


def _painted_skin(
    table: dict[str, Any], model: SkinModel, folder: Path, mesh: pyvista.PolyData
) -> Skin:
    """Return skin whose parameters a mesh file or an image has."""
    if "painted" in table:
        values = painted_vertices(mesh, folder / table["painted"])
        return Skin(model, values, (f"painted in {table['painted']}",))
    if "weights_at_one" not in table:
        names = ", ".join(parameter.name for parameter in model.parameters)
        raise DataError(
            f"[skin] with image needs weights_at_one = [{names}], the weights that the "
            "number 1.0 stands for in each channel"
        )
    values = painted_image(mesh, folder / table["image"], table["weights_at_one"])
    return Skin(model, values, (f"painted in {table['image']}",))


def _archive_skin(table: dict[str, Any], name: str, options: dict[str, Any]) -> Skin:
    """Fit the spectrum of one archive subject and site."""
    archive, chosen = _chosen(table, table.get("site"))
    if "thickness" in options:  # then the site only names the spectrum
        options = {key: options[key] for key in options if key != "site"}
    specular = table.get("specular", archive.attrs["specular"])
    model = skin_model(name, specular=specular, **options)
    return Skin.from_fit(_fitted(archive, chosen, model))


def archive_fit(table: Mapping[str, Any], site: str, model: SkinModel) -> Skin:
    """Return the skin of a [skin]'s person at another site, of a model that is given.

    Raises
    ------
    DataError
        If the archive has no spectrum of it.
    """
    return Skin.from_fit(_fitted(*_chosen(table, site), model))


def _chosen(table: Mapping[str, Any], site: str | None) -> tuple[Any, Any]:
    """Return an archive, and which of its records are of a subject's site."""
    archive = load_archive(table["archive"])
    asked = {**table, **({} if site is None else {"site": site})}
    for key in _WHO:
        if key not in asked:
            raise DataError(f"[skin] with archive needs {key} = ...")
    who = {key: str(asked[key]) for key in _WHO}
    return archive, archive_records(archive, table["archive"], who)


def archive_records(
    archive: xarray.Dataset, name: str, who: Mapping[str, str]
) -> NDArray[np.bool_]:
    """Return which records (n,) of an archive are of one subject and site.

    Parameters
    ----------
    archive : xarray.Dataset
        From :func:`load_archive`.
    name : str
        Its name, for messages.
    who : mapping of str to str
        ``origin``, ``subject`` and ``site``.

    Raises
    ------
    DataError
        If there is none.
    """
    chosen = np.ones(archive.sizes["record"], dtype=bool)
    for key in _WHO:
        chosen &= archive[key].values == who[key]
    if not chosen.any():
        sites = sorted(set(archive["site"].values))
        raise DataError(
            f"archive {name!r} has no spectrum of subject {who['subject']!r} of "
            f"{who['origin']!r} at {who['site']!r}; its "
            f"sites are {', '.join(sites)}, its origins "
            f"{', '.join(sorted(set(archive['origin'].values)))}"
        )
    return chosen


def _fitted(archive: Any, chosen: Any, model: SkinModel) -> SkinFit:
    """Return the fit of the mean of some of an archive's spectra."""
    spectrum = archive.reflectance.values[chosen].mean(axis=0)
    return fit_skin(spectrum, archive.wavelength.values, model)


def skin_from_fit_file(path: Path, record: int | str = 0) -> Skin:
    """Return the skin in a JSON file that ``skinviz fit`` wrote, by number or label."""
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
        raise DataError(f"{file}: {_NO_FIT}") from error
    if not known:
        raise DataError(f"{file}: written as {content['format']!r}; fit the file anew")
    if not isinstance(fits, list) or not all(isinstance(fit, dict) for fit in fits):
        raise DataError(f"{file}: {_NO_FIT}")
    record = _record(fits, record, file)
    model = skin_model(name, thickness=thickness, hypodermis=backing, **options)
    try:
        weights = fits[record]["parameters"]
        values = [weights[p.name]["value"] for p in model.parameters]
    except (KeyError, TypeError) as error:
        raise DataError(f"{file}: {_NO_FIT}") from error
    if any(value is None for value in values):
        raise DataError(
            f"{file}: record {record} was refused by the fit; choose another"
        )
    return Skin(model, as_numbers(values, f"{file}: the parameters of {record}"))


def _record(fits: list[dict[str, Any]], record: int | str, file: Path) -> int:
    """Return which of a file's fits a number or a label says."""
    if isinstance(record, str):
        labels = [str(fit.get("label")) for fit in fits]
        if labels.count(record) != 1:
            raise DataError(
                f"{file} has {labels.count(record)} fits labelled {record!r}; its "
                f"labels are {', '.join(labels[:_SHOWN])}"
                + (", ..." if len(labels) > _SHOWN else "")
            )
        return labels.index(record)
    if record >= len(fits):
        raise DataError(f"{file} has {len(fits)} records, 0 the first; got {record}")
    return record
