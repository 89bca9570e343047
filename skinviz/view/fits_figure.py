"""A figure of a few spectra with what one model or several made of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.colorimetry import encode_srgb, xyz_to_linear_srgb
from skinviz.view import panels
from skinviz.view.page import EDGE, STYLE, Cells, Margins, align_ylabels, lay_out, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

STYLES = (
    (panels.FITTED, "-"),
    (panels.SPECULAR, "--"),
    ("#d9a000", "-."),
    ("#7a4fa3", ":"),
)
"""Colour and dashes of each model's curve, told apart also by the colour-blind."""

_COLUMN, _BETWEEN = 2.9, 0.14  # inches: a panel, and what is free at its right
_CURVES, _RESIDUAL, _SWATCH, _LINE = 2.3, 1.0, 0.3, 0.155  # inches
_GAPS = (0.15, 0.6, 0.3)  # inches: under curves, residuals and colours
_LEFT = 0.72  # inches: for the words at the left of a panel
_LONGEST = 42  # letters of a spectrum's name that fit over its column
_CLEAR = 0.02  # least reflectance that an axis spans


@dataclass(frozen=True, eq=False)
class FittedSpectrum:
    """A measured spectrum (n,) and the fit of each model to it."""

    name: str
    measured: Array
    fits: tuple[SkinFit, ...]


def fits_figure(spectra: Sequence[FittedSpectrum], title: str, caption: str) -> Figure:
    """Return one column a spectrum: curves, residuals, colours and numbers.

    Parameters
    ----------
    spectra : sequence of FittedSpectrum
        A few, all fitted by the same models.
    title, caption : str
        Printed above and below, wrapped.
    """
    import matplotlib as mpl

    n = len(spectra)
    words = max(len(_numbers(spectrum.fits)) for spectrum in spectra)
    block = Cells(
        n,
        (_CURVES, _RESIDUAL, _SWATCH, _LINE * words),
        gap=_GAPS,
        least=_COLUMN,
        margins=Margins(left=_LEFT, right=_BETWEEN, top=0.3, bottom=0.12),
    )
    width = 2 * EDGE + n * (_LEFT + _COLUMN + _BETWEEN) + 0.01
    highest = max(_highest(spectrum) for spectrum in spectra)
    room = 1.2 + 0.085 * ((len(spectra[0].fits) + 2) // 2)  # rows of the legend
    spread = max(_spread(spectrum) for spectrum in spectra)
    with mpl.rc_context(STYLE):
        page = lay_out(width, [block], title=title, caption=caption)
        for spectrum, cell in zip(spectra, page.blocks[0], strict=True):
            curves, residual, colours, told = cell
            _draw_curves(curves, spectrum)
            curves.set_ylim(0, room * highest)
            _draw_residuals(residual, spectrum)
            residual.set_ylim(-spread, spread)
            align_ylabels([curves, residual])
            _draw_colours(colours, spectrum)
            told.set_axis_off()
            _write_numbers(page.figure, told, spectrum.fits)
    return page.figure


def _draw_curves(axes: Axes, spectrum: FittedSpectrum) -> None:
    """Draw measured and fitted reflectance."""
    fits = spectrum.fits
    bands = fits[0].wavelengths
    axes.plot(
        bands, spectrum.measured, "o", ms=3, color=panels.MEASURED, label="measured"
    )
    for k, fit in enumerate(fits):
        colour, dashes = STYLES[k % len(STYLES)]
        label = "fitted" if len(fits) == 1 else fit.model.name
        axes.plot(bands, fit.fitted, dashes, lw=1.4, color=colour, label=label)
    axes.set_ylabel("reflectance")
    name = spectrum.name
    axes.set_title(
        name if len(name) <= _LONGEST else f"…{name[1 - _LONGEST :]}", parse_math=False
    )
    # Skin is dark in the blue: the upper left stays free for words.
    axes.legend(loc="upper left", frameon=False, ncols=2, columnspacing=1.2)
    panels.wavelength_axis(axes, labelled=False)


def _draw_residuals(axes: Axes, spectrum: FittedSpectrum) -> None:
    """Draw measured minus fitted reflectance, of one model as sticks."""
    bands = spectrum.fits[0].wavelengths
    axes.axhline(0, lw=0.8, color="0.6")
    for k, fit in enumerate(spectrum.fits):
        colour, dashes = STYLES[k % len(STYLES)]
        residual = spectrum.measured - fit.fitted
        if len(spectrum.fits) == 1:
            axes.vlines(bands, 0, residual, lw=1.2, color=colour)
            axes.plot(bands, residual, "o", ms=2.5, color=colour, clip_on=False)
        else:
            axes.plot(bands, residual, dashes, lw=1.3, color=colour)
    axes.set_ylabel("residual")
    panels.wavelength_axis(axes)


def _draw_colours(axes: Axes, spectrum: FittedSpectrum) -> None:
    """Draw the measured colour and each model's edge to edge, under D65."""
    fits = spectrum.fits
    xyz = np.stack([fits[0].xyz[0], *(fit.xyz[1] for fit in fits)])
    names = ["measured", *(fit.model.name for fit in fits)]
    if len(fits) == 1:
        names[1] = "fitted"
    known = np.isfinite(xyz).all(axis=-1, keepdims=True)
    shown = np.where(known, encode_srgb(xyz_to_linear_srgb(np.nan_to_num(xyz))), 1.0)
    axes.imshow(shown[None], aspect="auto", extent=(0, len(names), 0, 1))
    size = 7 if len(names) < 5 else 6
    axes.set_xticks(np.arange(len(names)) + 0.5, names, fontsize=size)
    axes.set_yticks([])
    axes.tick_params(length=0, pad=2)


def _write_numbers(figure: Figure, axes: Axes, fits: Sequence[SkinFit]) -> None:
    """Write the numbers below a spectrum, from the upper left corner of axes."""
    width, height = figure.get_size_inches()
    box = axes.get_position()
    at = (box.x0 * width, (1 - box.y1) * height)
    write(figure, _numbers(fits), at, _LINE, fontsize=7.5, family="monospace")


def _numbers(fits: Sequence[SkinFit]) -> list[str]:
    """Return the lines of numbers below a spectrum."""
    if len(fits) > 1:
        lines = [f"{'':<14}{'SSE61':>8}{'ΔE00':>7}{'BIC':>9}"]
        return lines + [
            f"{fit.model.name:<14}{fit.sse_61:>8.4f}{fit.delta_e:>7.2f}{fit.bic:>9.1f}"
            for fit in fits
        ]
    (fit,) = fits
    lines = [
        f"{name:<14}{value:>8.4f}  [{low:.4f}, {high:.4f}]"
        for name, value, (low, high) in zip(
            fit.parameters, fit.values, fit.interval, strict=True
        )
    ]
    return [
        *lines,
        f"{'SSE61':<14}{fit.sse_61:>8.4f}  RMSE {fit.rmse:.4f}",
        f"{'ΔE00, D65':<14}{fit.delta_e:>8.2f}  {fit.status}",
    ]


def _highest(spectrum: FittedSpectrum) -> float:
    """Return the highest reflectance that is drawn."""
    curves = [spectrum.measured, *(fit.fitted for fit in spectrum.fits)]
    return float(np.nanmax(np.concatenate(curves), initial=_CLEAR))


def _spread(spectrum: FittedSpectrum) -> float:
    """Return how far the residuals' axis goes."""
    apart = [np.abs(spectrum.measured - fit.fitted) for fit in spectrum.fits]
    return 1.15 * float(np.nanmax(np.concatenate(apart), initial=0.005))
