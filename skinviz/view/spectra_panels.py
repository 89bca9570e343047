"""Panels of many spectra: groups with their spread, and rows of swatches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz.spectra.colorimetry import encode_srgb, xyz_to_linear_srgb
from skinviz.view.page import inches_of
from skinviz.view.panels import wavelength_axis
from skinviz.view.styles import line

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

ROW = 0.24
"""Height of a row of swatches. [inches]"""

_SMALL = 7.0  # points


@dataclass(frozen=True, eq=False)
class Band:
    """A curve over wavelength, perhaps with a spread around it.

    Attributes
    ----------
    label : str
        For the legend.
    middle : (n,) ndarray
        The curve.
    low, high : (n,) ndarray, optional
        Between which the spread is shaded.
    """

    label: str
    middle: Array
    low: Array | None = None
    high: Array | None = None


def band_of(label: str, spectra: ArrayLike) -> Band:
    """Return mean ± standard deviation of spectra (m, n), unmeasured bands left out.

    A single spectrum has no spread.
    """
    own = np.asarray(spectra, dtype=np.float64)
    known = np.isfinite(own).sum(axis=0)
    mean = np.where(known, np.nansum(own, axis=0) / np.maximum(known, 1), np.nan)
    if len(own) < 2:
        return Band(label, mean)
    square = np.nansum((own - mean) ** 2, axis=0) / np.maximum(known - 1, 1)
    spread = np.sqrt(square)
    return Band(label, mean, mean - spread, mean + spread)


def bands_panel(
    axes: Axes,
    wavelengths: ArrayLike,
    bands: Sequence[Band],
    *,
    ylabel: str = "reflectance",
    first: int = 0,
) -> list[Artist]:
    """Draw curves with their spreads over wavelength; return them for a legend.

    Parameters
    ----------
    axes : Axes
        Where.
    wavelengths : (n,) array_like
        [nm]
    bands : sequence of Band
        Each gets a colour, dashes and a marker of its own.
    ylabel : str
        With the unit.
    first : int
        The style of the first curve: panels that share a legend count on.
    """
    nm = np.asarray(wavelengths, dtype=np.float64)
    handles: list[Artist] = []
    for k, band in enumerate(bands, first):
        own = line(k)
        if band.low is not None and band.high is not None:
            axes.fill_between(
                nm, band.low, band.high, color=own.colour, alpha=0.1, lw=0
            )
            for edge in (band.low, band.high):
                axes.plot(nm, edge, color=own.colour, ls=own.dashes, lw=0.5)
        handles += axes.plot(nm, band.middle, label=band.label, **own(nm.size, 2 * k))
    axes.set_ylabel(ylabel)
    wavelength_axis(axes)
    return handles


@dataclass(frozen=True, eq=False)
class Swatch:
    """A colour to be shown with its numbers.

    Attributes
    ----------
    label : str
        What it is the colour of.
    rgb : (3,) or (k, 3) ndarray
        sRGB, 0 to 1; several are drawn edge to edge.
    lab : (3,) ndarray, optional
        L*, a*, b*.
    error : float, optional
        95 % of what the colour may be lies within it. [ΔE00]
    note : str
        Follows the numbers.
    """

    label: str
    rgb: Array
    lab: Array | None = None
    error: float | None = None
    note: str = ""

    @property
    def numbers(self) -> str:
        """L*, a*, b* and the error as text."""
        words = []
        if self.lab is not None:
            words.append("L* {:.1f}  a* {:.1f}  b* {:.1f}".format(*self.lab))
        if self.error is not None:
            words.append(f"± {self.error:.1f} ΔE00")
        return "  ".join([*words, *([self.note] if self.note else [])])


def swatch_rows(axes: Axes, swatches: Sequence[Swatch]) -> None:
    """Draw a row for each swatch: its colour, its name, and its numbers under that.

    Give the axes ``ROW`` inches a swatch, and 1.6 inches of width or more.
    """
    width, height = inches_of(axes)
    n = len(swatches)
    axes.set_xlim(0, width)
    axes.set_ylim(n, 0)
    axes.set_axis_off()
    parts = max((len(np.atleast_2d(swatch.rgb)) for swatch in swatches), default=1)
    patch = min(max(0.5, 0.24 * parts), 0.3 * width)
    for row, swatch in enumerate(swatches):
        axes.imshow(
            np.atleast_2d(swatch.rgb)[None],
            extent=(0, patch, row + 0.92, row + 0.08),
            aspect="auto",
            interpolation="nearest",
        )
        lines = [word for word in (swatch.label, swatch.numbers) if word]
        axes.text(
            patch + 0.07,
            row + 0.5,
            "\n".join(lines),
            va="center",
            fontsize=min(_SMALL, height / n * 72 / 1.25 / max(len(lines), 1)),
            linespacing=1.05,
            parse_math=False,
        )
    axes.set_xlim(0, width)
    axes.set_ylim(n, 0)


def srgb_of(xyz: ArrayLike) -> Array:
    """Return sRGB (..., 3), 0 to 1, of XYZ with Y = 1 for white; clipped."""
    return encode_srgb(xyz_to_linear_srgb(xyz))
