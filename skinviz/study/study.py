"""A study: labelled spectra of subjects, and what of them is missing and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.errors import ArgumentError, DataError

if TYPE_CHECKING:
    import xarray

FACTORS = ("site", "condition", "group", "subject")
"""What a study can be compared by."""

MISSING, LEFT_OUT, CHANGED = "missing", "left out", "resampled"
"""What can have become of a record: not there, there but not used, changed."""


@dataclass(frozen=True)
class Gap:
    """A record that is not as it should be.

    Attributes
    ----------
    what : str
        "missing", "left out" or "resampled".
    subject, site, condition : str
        Whose and where, "" where that is not known or was not told.
    repeat : int
        Which repeat, 0 for all of them.
    file : str
        Of the record, "" if there is none.
    why : str
        In words.
    """

    what: str
    subject: str
    site: str
    condition: str
    repeat: int
    file: str
    why: str

    def __str__(self) -> str:
        """Return the gap in one line."""
        where = ", ".join(
            text
            for text in (
                self.subject,
                self.site,
                self.condition,
                f"repeat {self.repeat}" if self.repeat else "",
            )
            if text
        )
        return f"{self.what}: {where or self.file}: {self.why}"


@dataclass(frozen=True)
class Shape:
    """A subject's own hand: a mesh, or a raw scan that is still to be cleaned."""

    path: Path
    unit: str | None
    raw: bool


@dataclass(frozen=True, eq=False)
class Study:
    """Spectra of subjects at body sites, in conditions and repeats.

    Subjects are pseudonyms; a name stands for one person throughout the study.

    Attributes
    ----------
    title : str
        What the study is about.
    spectra : xarray.Dataset
        As :func:`load_archive` gives it, with the coordinates ``condition`` ("" if
        there is but one), ``repeat`` (1, 2, ...) and ``file``.
    layers : mapping of str to (float, float)
        Thickness of epidermis and dermis at each site. [mm]
    gaps : tuple of Gap
        What is missing, was left out or was changed, and why.
    shapes : mapping of str to Shape
        Hands of the subjects that have their own.
    gonio : mapping of (str, str) to Path
        Goniometer readings of a subject and site ("": any), as
        :func:`read_gonio` takes them.
    """

    title: str
    spectra: xarray.Dataset
    layers: Mapping[str, tuple[float, float]]
    gaps: tuple[Gap, ...] = ()
    shapes: Mapping[str, Shape] = field(default_factory=dict)
    gonio: Mapping[tuple[str, str], Path] = field(default_factory=dict)

    @property
    def specular(self) -> str | float:
        """How the surface reflection was measured."""
        how: str | float = self.spectra.attrs["specular"]
        return how

    def levels(self, factor: str) -> tuple[str, ...]:
        """Return the values of a factor in the order in which they first occur."""
        if factor not in FACTORS:
            raise ArgumentError(
                f"unknown factor {factor!r}; choose one of {', '.join(FACTORS)}"
            )
        return tuple(dict.fromkeys(map(str, self.spectra[factor].values)))

    def raise_for_gaps(self) -> None:
        """Raise if anything is missing, was left out or was changed.

        Raises
        ------
        DataError
            Says how many gaps there are, and the first.
        """
        if self.gaps:
            raise DataError(
                f"study {self.title!r} is not whole, {len(self.gaps)} gaps; the first "
                f"is {self.gaps[0]}; mend it, or leave --strict out to have all listed"
            )
