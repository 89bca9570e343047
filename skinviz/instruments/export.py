"""Files of what follows from a session: spectra for fits, the lobe for its fit."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinviz._files import whole_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.instruments.derive import Derived, spectra_of
from skinviz.instruments.lobe import Lobe
from skinviz.instruments.skinlog import SkinLog

if TYPE_CHECKING:
    import xarray

SUFFIXES = (".nc", ".csv", ".tsv", ".spdx", ".cgats")
"""What spectra are exported as."""

_NAMES = {"value": "radiance_factor", "u": "u_radiance_factor"}
_PARTS = ("diffuse", "specular", "u_diffuse", "u_specular")


def export_spectra(
    path: Path, log: SkinLog, derived: Derived, source: str
) -> list[Path]:
    """Write the reflectance of a session in the format of the suffix.

    Parameters
    ----------
    path : Path
        ``.nc`` holds everything: reflectance with its uncertainty, every radiance
        factor, body and surface. Others hold reflectance in the bands that all
        records have; ``.spdx`` one spectrum a file, named after it where there are
        several.
    log, derived
        The session and what follows from it.
    source : str
        Name of the log.

    Returns
    -------
    files : list of Path
        What was written.

    Raises
    ------
    ArgumentError
        If the suffix is unknown, or there is no band that all records have.
    """
    from skinviz.spectra.files import write_spectra

    suffix = one_of(path.suffix.lower(), SUFFIXES, "suffix of an export")
    spectra = spectra_of(log, derived, source)
    if suffix == ".nc":
        return [write_spectra(path, spectra.merge(parts_of(derived)))]
    known = np.isfinite(spectra["reflectance"].values).all(axis=0)
    if not known.any():
        raise ArgumentError(f"{path}: no band has all records; write .nc")
    spectra = spectra.isel(wavelength=known)
    typical = float(np.median(spectra["uncertainty"].values))
    spectra.attrs["comment"] = json.dumps({"standard_uncertainty": round(typical, 6)})
    if suffix != ".spdx" or spectra.sizes["record"] == 1:
        return [write_spectra(path, spectra)]
    return [
        write_spectra(name, spectra.isel(record=[i]))
        for i, name in enumerate(_named(path, spectra["label"].values.tolist()))
    ]


def parts_of(derived: Derived) -> xarray.Dataset:
    """Return every radiance factor, and body and surface where they are known.

    Returns
    -------
    parts : xarray.Dataset
        ``radiance_factor`` (body_site, illumination, state, wavelength), ``diffuse``
        and ``specular`` (body_site, illumination, wavelength), each with ``u_`` and
        its name [1]; angles in degrees.
    """
    import xarray

    plan = derived.frames.plan
    sites, angles, states = plan.sites, sorted(plan.illumination), plan.states
    pairs = [(site, angle) for site in sites for angle in angles]
    shape = (len(sites), len(angles))
    found: dict[str, Any] = {}
    for name in ("value", "u"):
        values = [
            [getattr(derived.factors[*pair, state], name) for state in states]
            for pair in pairs
        ]
        found[_NAMES[name]] = (
            ("body_site", "illumination", "state", "wavelength"),
            np.reshape(values, (*shape, len(states), -1)),
            {"units": "1"},
        )
    for name in _PARTS if derived.parts else ():
        values = [getattr(derived.parts[pair], name) for pair in pairs]
        found[name] = (
            ("body_site", "illumination", "wavelength"),
            np.reshape(values, (*shape, -1)),
            {"units": "1"},
        )
    coordinates = {
        "body_site": np.array(sites),
        "illumination": ("illumination", np.array(angles), {"units": "degree"}),
        "state": np.array(states),
        "wavelength": ("wavelength", derived.frames.wavelengths, {"units": "nm"}),
    }
    return xarray.Dataset(found, coords=coordinates)


def write_lobe(path: Path, lobe: Lobe, source: str) -> Path:
    """Write the specular part by angle as :func:`skinviz.read_gonio` reads it.

    Raises
    ------
    ArgumentError
        If the suffix is not .csv.
    """
    one_of(path.suffix.lower(), (".csv",), "suffix of a lobe's readings")
    with (
        whole_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as text,
    ):
        text.write(f"# source: {' '.join(source.split())}\n")
        text.write("# unit: the perfect diffuser that faces the lamp\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["illumination_deg", "viewing_deg", "specular", "uncertainty"])
        columns = (lobe.illumination, lobe.viewing, lobe.specular, lobe.uncertainty)
        for row in zip(*columns, strict=True):
            rows.writerow([repr(float(value)) for value in row])
    return path


def _named(path: Path, labels: Sequence[str]) -> list[Path]:
    """Return a path for each record with its label in the name, all different."""
    words = [re.sub(r"[\W_]+", "-", label.lower()).strip("-") for label in labels]
    if len(set(words)) < len(words) or not all(words):
        words = [f"{i}-{word}".rstrip("-") for i, word in enumerate(words, start=1)]
    return [path.with_name(f"{path.stem}-{word}{path.suffix}") for word in words]
