"""What every format reads into, and the rules of text that formats share.

What does not belong here: anything that only one format has.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import one_of
from skinviz.errors import ArgumentError, DataError

if TYPE_CHECKING:
    import xarray

LIST, CUBE = ("record",), ("line", "sample")
"""Dimensions of a list of spectra, and of a cube, before the wavelength."""

METADATA = ("specular", "geometry", "instrument", "date", "comment")
"""Attributes that text formats carry, where the format has a place for them."""

SCALES = {"fraction": 1.0, "percent": 100.0}
"""What reflectance 1 is written as: in 0–1, or in 0–100."""

_IN_NM = {
    1.0: ("nm", "nanometer", "nanometers", "nanometre", "nanometres"),
    1000.0: (
        *("um", "µm", "μm", "micron", "microns", "micrometer", "micrometers"),
        *("micrometre", "micrometres"),
    ),
}
# Control characters, line ends that are none in ASCII, and what XML forbids.
_UNWRITABLE = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")


@dataclass(frozen=True, eq=False)
class RawSpectra:
    """Spectra as a file has them, on the file's own scale, not yet judged.

    Attributes
    ----------
    values : (record, n) or (line, sample, n) ndarray of float32 or float64
        As written, except that missing ones are NaN. Owned: scaled in place.
    wavelengths : (n,) ndarray
        As ordered in the file. [nm]
    labels : list of str or None
        One a record; None for a cube.
    written_as : float or None
        What the file says that reflectance 1 is written as.
    unless_said : float or None
        The same where neither file nor caller says it; None if they must.
    attributes : dict
        Those of ``METADATA`` that the file states, or all for netCDF.
    rest : xarray.Dataset or None
        What else is to be handed on, as it is.
    """

    values: NDArray[Any]
    wavelengths: NDArray[np.float64]
    labels: list[str] | None
    written_as: float | None = None
    unless_said: float | None = 1.0
    attributes: dict[str, Any] = field(default_factory=dict)
    rest: xarray.Dataset | None = None


class Format(Protocol):
    """What a module of a format has.

    ``KINDS`` are the dimensions it can hold (``LIST``, ``CUBE``), ``MISSING`` says
    whether it can mark a band as missing.
    """

    @property
    def KINDS(self) -> tuple[tuple[str, ...], ...]: ...  # noqa: N802, D102

    @property
    def MISSING(self) -> bool: ...  # noqa: N802, D102

    def read(self, file: Path) -> RawSpectra:
        """Return what an existing file has, or raise ``DataError``."""

    def write(self, file: Path, spectra: xarray.Dataset) -> None:
        """Write spectra that were found fit, whole or not at all."""


def read_text(file: Path, what: str, *, at_most: int, fallback: str = "") -> str:
    """Return a file's text, UTF-8 or the fallback; refuse what is no text or huge."""
    size = file.stat().st_size
    if size > at_most:
        raise DataError(
            f"{file}: {size / 2**20:.0f} MiB are too many for {what}; expected at most "
            f"{at_most / 2**20:.0f}"
        )
    try:
        content = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror}") from error
    for encoding in filter(None, ("utf-8-sig", fallback)):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise DataError(f"{file}: not a text file; expected {what}")


def note(line: str) -> tuple[str, str]:
    """Return key and value of a comment like ``# specular: included``."""
    key, _, value = line.lstrip("#").partition(":")
    return key.strip().lower(), value.strip()


def stated(found: Mapping[str, str]) -> dict[str, str]:
    """Return those of ``METADATA`` that are given and say something."""
    return {key: found[key] for key in METADATA if found.get(key)}


def scale_of(word: str, file: Path) -> float:
    """Return what 1 is written as by the word that a file declares it with."""
    try:
        return SCALES[one_of(word, SCALES, "scale")]
    except ArgumentError as error:
        raise DataError(f"{file}: {error}") from error


def is_number(cell: str) -> bool:
    """Return whether a cell reads as a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python's own spelling, nobody else's


def number(cell: str, where: str) -> float:
    """Return a cell's number or say where it is not one."""
    if not is_number(cell):
        what = "an empty cell" if not cell else repr(cell[:40])
        hint = "; write decimal points, not commas" if "," in cell else ""
        raise DataError(f"{where}: expected a number, found {what}{hint}")
    return float(cell)


def in_nanometres(
    wavelengths: NDArray[np.float64], unit: str, file: Path
) -> NDArray[np.float64]:
    """Return wavelengths in nm, from the unit that a file states."""
    for factor, names in _IN_NM.items():
        if unit.strip().lower() in names:
            # Rounded to 1e-9 nm: 0.57 µm is 570 nm, not 569.9999999999999.
            return wavelengths if factor == 1 else np.round(wavelengths * factor, 9)
    raise DataError(
        f"{file}: wavelengths are in {unit[:40]!r}; expected nanometers or micrometers"
    )


def one_line(value: object, what: str, file: Path) -> str:
    """Return text that a line of any format can hold, or refuse it."""
    text = str(value)
    if _UNWRITABLE.search(text):
        raise ArgumentError(
            f"{file}: {what} {text[:40]!r} has a line break or control character, "
            f"which {file.suffix} cannot hold; remove it"
        )
    return text


def joined(text: str) -> str:
    """Return text of several lines on one."""
    return " ".join(filter(None, (line.strip() for line in text.splitlines())))


def labels_to_write(spectra: xarray.Dataset, file: Path) -> list[str]:
    """Return the labels of a list of spectra as text that comes back as it is."""
    labels = [one_line(label, "the label", file) for label in spectra["label"].values]
    for label in labels:
        if not label or label != label.strip():
            raise ArgumentError(
                f"{file}: the label {label[:40]!r} is empty or has spaces around it, "
                f"which {file.suffix} cannot hold; name the spectrum or write .nc"
            )
    return labels


def notes_to_write(spectra: xarray.Dataset, file: Path) -> dict[str, str]:
    """Return those of ``METADATA`` that spectra have as text of one line each."""
    return {
        key: one_line(spectra.attrs[key], f"the attribute {key}", file).strip()
        for key in METADATA
        if key in spectra.attrs
    }
