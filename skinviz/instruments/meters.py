"""What every spectroradiometer gives and is asked: readings, identity, one protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from skinviz.instruments.errors import MalformedReply
from skinviz.instruments.link import Exchange

Array = NDArray[np.float64]

ROUNDING = 6e-4
"""By how much a printed integral of four digits may miss the sum of its spectrum,
relatively. Rounding alone reached 4.9e-4 in 3,000 spectra."""


@dataclass(frozen=True)
class DeviceInfo:
    """Who an instrument says it is."""

    maker: str
    model: str
    serial: str
    firmware: str = ""

    @property
    def name(self) -> str:
        """Maker, model and serial number, in words."""
        return f"{self.maker} {self.model}, serial number {self.serial or 'not told'}"


@dataclass(frozen=True)
class Grid:
    """The wavelengths that an instrument measures at. [nm]"""

    first: float
    step: float
    count: int

    @property
    def wavelengths(self) -> Array:
        """The wavelengths (count,), ascending. [nm]"""
        return np.asarray(self.first + self.step * np.arange(self.count))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """What a reply holds, and what is odd about it without being wrong."""

    radiance: Array
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Reading:
    """One spectrum as an instrument sent it.

    Attributes
    ----------
    wavelengths, radiance : (n,) ndarray
        [nm], [W sr⁻¹ m⁻² nm⁻¹]
    exposure : float or None
        Integration time, where the instrument tells it. [s]
    warnings : tuple of str
        What the instrument says of data that it sent all the same.
    raw : bytes
        The reply.
    """

    wavelengths: Array
    radiance: Array
    exposure: float | None
    warnings: tuple[str, ...]
    raw: bytes


class Spectroradiometer(Protocol):
    """A driver. All raise ``InstrumentError`` and its kinds, and nothing else."""

    @property
    def info(self) -> DeviceInfo:
        """Who the instrument says it is."""

    def configure(
        self, *, exposure: float = 0.0, average: int = 1, sync: bool = False
    ) -> None:
        """Set integration time [s, 0 adaptive], exposures averaged, mains sync."""

    def measure(self, *, within: float | None = None) -> Reading:
        """Measure once, in so many seconds at most."""

    def reread(self) -> Reading:
        """Return the last measurement's data, sent once more."""

    def transcript(self) -> tuple[Exchange, ...]:
        """Return what was said on the line since the last call."""

    def close(self) -> None:
        """Leave the instrument to its own keys, and close the port."""

    def __enter__(self) -> Self:
        """Return the driver, which is open."""

    def __exit__(self, *_: object) -> None:
        """Close."""


def require_grid(told: Array, grid: Grid, raw: bytes) -> None:
    """Refuse wavelengths (count,) that are not those of the grid.

    Raises
    ------
    MalformedReply
        If one is missing, doubled or another.
    """
    if told.shape != (grid.count,) or not (np.abs(told - grid.wavelengths) < 0.5).all():
        raise MalformedReply(
            "the wavelengths of the reply are not the instrument's own; read the data "
            "again",
            raw=raw,
        )


def sum_differs(radiance: Array, step: float, integral: float) -> bool:
    """Return whether a printed integral is another than Σ radiance × step."""
    total = float(radiance.sum()) * step
    return not abs(total - integral) <= ROUNDING * max(abs(total), abs(integral))


def printed_number(text: bytes, what: str, raw: bytes) -> float:
    """Return a finite number as instruments print it, or refuse it.

    Raises
    ------
    MalformedReply
        If it is none.
    """
    try:
        value = float(text) if b"_" not in text else np.nan
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise MalformedReply(
            f"{what} is {text[:20]!r}, which is no number; read the data again",
            raw=raw,
        )
    return value


def printed_count(text: bytes, what: str, raw: bytes) -> int:
    """Return a whole number as instruments print it, or refuse it.

    Raises
    ------
    MalformedReply
        If it is none.
    """
    value = printed_number(text, what, raw)
    if value != int(value):
        raise MalformedReply(
            f"{what} is {text[:20]!r}, which is no whole number; read the data again",
            raw=raw,
        )
    return int(value)


def as_grid(first: float, step: float, count: int, last: float, raw: bytes) -> Grid:
    """Return a grid that is told in four numbers, if they agree and can be.

    Raises
    ------
    MalformedReply
        If they do not.
    """
    plausible = 150 <= first < last <= 3000 and 0.05 <= step <= 50
    if not plausible or abs(first + step * (count - 1) - last) > 0.01 * step:
        raise MalformedReply(
            f"a grid of {count} points from {first:g} to {last:g} nm by {step:g} nm is "
            "none; ask again",
            raw=raw,
        )
    return Grid(first, step, count)
