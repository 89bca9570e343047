"""IES TM-27-14, the XML file of one spectrum.

References
----------
.. [1] ANSI/IES TM-27-14, Standard format for the electronic transfer of spectral
   data, Illuminating Engineering Society (2014).
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from skinviz._files import whole_file
from skinviz.errors import ArgumentError, DataError
from skinviz.spectra.formats.raw import (
    LIST,
    RawSpectra,
    joined,
    labels_to_write,
    notes_to_write,
    number,
)

if TYPE_CHECKING:
    import xarray

KINDS, MISSING = (LIST,), False

# The name of the standard's elements, not an address to fetch.
_NAMESPACE = "http://www.ies.org/iestm2714"
_ROOT = re.compile(r"\{([^}]*iestm2714)\}IESTM2714")
_AT_MOST = 4 * 2**20  # bytes; 0.1 nm steps from 200 to 2500 nm need 1.5

_REFLECTANCES = ("reflectance", "R-Factor")
_LIGHTS = ("flux", "intensity", "irradiance", "radiance", "exitance", "relative")
# What the standard's codes say of the surface reflection; None where nothing.
_GEOMETRIES = {
    **dict.fromkeys(("di:8", "8:di"), "included"),
    **dict.fromkeys(("de:8", "8:de"), "excluded"),
    **dict.fromkeys(("45a:0", "45c:0", "0:45a", "45x:0", "0:45x"), "excluded"),
    **dict.fromkeys(("d:d", "d:0", "other"), None),
}
_NOTHING = ("None", "N/A")  # how other writers say that they say nothing
_NOTED = ("specular", "geometry")  # kept as lines of the comments where it must be


def read(file: Path) -> RawSpectra:
    """Return the reflectance of a TM-27-14 file, which has 0–1 by its standard."""
    return _read(file, _REFLECTANCES)


def read_lamp(file: Path) -> RawSpectra:
    """Return the light of a TM-27-14 file, in whatever unit it is."""
    return _read(file, _LIGHTS)


def _read(file: Path, quantities: tuple[str, ...]) -> RawSpectra:
    """Return the spectrum of a TM-27-14 file if it is of one of the quantities."""
    root = _root(file)
    named = _ROOT.fullmatch(root.tag)
    if named is None:
        raise DataError(
            f"{file}: the outermost element is {root.tag[:60]!r}; a TM-27-14 file has "
            "IESTM2714 in the namespace iestm2714"
        )
    spaces = {"": named[1]}
    found = root.findall("SpectralDistribution", spaces)
    if len(found) != 1:
        raise DataError(
            f"{file}: {len(found)} elements SpectralDistribution; a TM-27-14 file has "
            "one"
        )
    quantity = _text(found[0], "SpectralQuantity", spaces)
    if quantity not in quantities:
        raise DataError(
            f"{file}: the SpectralQuantity is {quantity[:40]!r}; spectra of "
            f"{' or '.join(quantities)} are read"
        )
    wavelengths, values = _bands(found[0], spaces, file)
    header = root.find("Header", spaces)
    header = ET.Element("Header") if header is None else header
    return RawSpectra(
        values=values[np.newaxis],
        wavelengths=wavelengths,
        labels=[_text(header, "Description", spaces) or file.stem],
        written_as=1.0,
        attributes=_attributes(header, found[0], spaces),
    )


def write(
    file: Path, spectra: xarray.Dataset, *, created: datetime | None = None
) -> None:
    """Write one spectrum; what the standard has no element for is in the comments."""
    if spectra.sizes["record"] != 1:
        raise ArgumentError(
            f"{file}: a TM-27-14 file has one spectrum, {spectra.sizes['record']} were "
            "given; write each to a file of its own (spectra.isel(record=[0])) or all "
            "to .csv or .nc"
        )
    moment = datetime.now(UTC) if created is None else created
    document = _document(spectra, file, moment.strftime("%Y-%m-%dT%H:%M:%S"))
    with whole_file(file) as partial:
        document.write(partial, encoding="utf-8", xml_declaration=True)


def _document(
    spectra: xarray.Dataset, file: Path, created: str
) -> ET.ElementTree[ET.Element]:
    """Return the document of one spectrum."""
    notes = notes_to_write(spectra, file)
    (label,) = labels_to_write(spectra, file)
    first = notes.get("comment", "").partition(":")[0]
    if label in _NOTHING or first.strip().lower() in _NOTED:
        raise ArgumentError(
            f"{file}: the label {label!r} or a comment that begins {first[:20]!r} "
            "would be read as something else; change it"
        )
    geometry = notes.get("geometry", "other")
    coded = geometry if geometry in _GEOMETRIES else "other"
    root = ET.Element("IESTM2714", {"xmlns": _NAMESPACE, "version": "1.0"})
    header = ET.SubElement(root, "Header")
    for tag, text in {
        "Description": label,
        "DocumentCreator": "skinviz",
        "MeasurementEquipment": notes.get("instrument", ""),
        "ReportDate": notes.get("date", ""),
        "DocumentCreationDate": created,
        "Comments": "\n".join(_comments(notes, coded)),
    }.items():
        if text:
            ET.SubElement(header, tag).text = text
    body = ET.SubElement(root, "SpectralDistribution")
    ET.SubElement(body, "SpectralQuantity").text = "reflectance"
    ET.SubElement(body, "ReflectionGeometry").text = coded
    row = spectra["reflectance"].values[0]
    for nm, value in zip(spectra["wavelength"].values, row, strict=True):
        band = ET.SubElement(body, "SpectralData", wavelength=repr(float(nm)))
        band.text = repr(float(value))
    ET.indent(root)
    return ET.ElementTree(root)


def _comments(notes: dict[str, str], coded: str) -> list[str]:
    """Return the lines of comments, with what the geometry's code does not say."""
    lines = [notes["comment"]] if "comment" in notes else []
    if notes.get("geometry", coded) != coded:
        lines.append(f"geometry: {notes['geometry']}")
    if "specular" in notes and notes["specular"] != _GEOMETRIES[coded]:
        lines.append(f"specular: {notes['specular']}")
    return lines


def _root(file: Path) -> ET.Element:
    """Return the parsed document; one that defines entities or is huge is refused."""
    if file.stat().st_size > _AT_MOST:
        raise DataError(
            f"{file}: a TM-27-14 file of one spectrum has less than "
            f"{_AT_MOST // 2**20} MiB"
        )
    try:
        content = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror}") from error
    # Looked for before parsing, in every encoding of XML: UTF-16 only adds zeros.
    if b"<!DOCTYPE" in content.replace(b"\0", b""):
        raise DataError(
            f"{file}: has a DOCTYPE, which TM-27-14 does not know and which may hide "
            "endless entities; remove it"
        )
    try:
        return ET.fromstring(content)
    except (ET.ParseError, ValueError, LookupError) as error:  # of unknown encodings
        raise DataError(f"{file}: not whole XML: {error}") from error


def _text(parent: ET.Element, tag: str, spaces: dict[str, str]) -> str:
    """Return an element's text on one line; "" if it says nothing."""
    text = joined(parent.findtext(tag, "", spaces) or "")
    return "" if text in _NOTHING else text


def _bands(
    body: ET.Element, spaces: dict[str, str], file: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return wavelengths and values of the elements SpectralData."""
    bands = [
        (
            number(band.get("wavelength", ""), f"{file}, wavelength of band {i}"),
            number((band.text or "").strip(), f"{file}, band {i}"),
        )
        for i, band in enumerate(body.findall("SpectralData", spaces), start=1)
    ]
    if not bands:
        raise DataError(f"{file}: no element SpectralData")
    wavelengths, values = np.array(bands).T.copy()
    return wavelengths, values


def _attributes(
    header: ET.Element, body: ET.Element, spaces: dict[str, str]
) -> dict[str, str]:
    """Return what the header, the geometry and the comments tell."""
    attributes: dict[str, str] = {}
    geometry = _text(body, "ReflectionGeometry", spaces)
    if geometry and geometry != "other":
        attributes["geometry"] = geometry
    implied = _GEOMETRIES.get(geometry)
    if implied:
        attributes["specular"] = implied
    remarks = []
    for line in (header.findtext("Comments", "", spaces) or "").splitlines():
        key, _, value = line.partition(":")
        if key.strip().lower() in _NOTED and value.strip():
            attributes[key.strip().lower()] = value.strip()
        else:
            remarks.append(line)
    told = {
        "instrument": _text(header, "MeasurementEquipment", spaces),
        "date": _text(header, "ReportDate", spaces),
        "comment": joined("\n".join(remarks)),
    }
    return attributes | {k: v for k, v in told.items() if v and v not in _NOTHING}
