"""Spectral panels, each drawn on axes that it is given."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.rendering.shade import VertexSpectrum
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.colorimetry import (
    colour_matching_functions,
    encode_srgb,
    spectrum_to_xyz,
    xyz_to_linear_srgb,
)
from skinviz.view.page import inches_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

Array = NDArray[np.float64]

MEASURED, FITTED, SPECULAR = "#1a1a1a", "#c8452d", "#2d6fc8"
"""Colours of the curves, told apart also by the colour-blind and by their dashes."""

_VISIBLE = (400.0, 700.0)
_TICKS_FIT = 1.9  # inches, from which a wavelength every 50 nm can be read
_STRIP = 5.0  # points: height of the colours under the wavelength axis


def reflectance_panel(axes: Axes, measured: Array, fit: SkinFit) -> None:
    """Draw measured and fitted reflectance of one spectrum over its bands."""
    axes.plot(fit.wavelengths, measured, "o", ms=3, color=MEASURED, label="measured")
    axes.plot(fit.wavelengths, fit.fitted, "-", lw=1.4, color=FITTED, label="fitted")
    axes.set_ylabel("reflectance")
    # Skin is dark in the blue: the upper left stays free for words.
    axes.set_ylim(0, 1.35 * float(np.nanmax([measured, fit.fitted])) or 1.0)
    axes.legend(loc="upper left", frameon=False, ncols=2, columnspacing=1.2)
    axes.annotate(
        weights_text(fit),
        (0, 1),
        xytext=(9, -22),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
        fontsize=7.5,
    )
    wavelength_axis(axes, labelled=False)


def residual_panel(axes: Axes, measured: Array, fit: SkinFit) -> None:
    """Draw measured minus fitted reflectance."""
    residual = measured - fit.fitted
    axes.axhline(0, lw=0.8, color="0.6")
    axes.vlines(fit.wavelengths, 0, residual, lw=1.2, color=FITTED)
    axes.plot(fit.wavelengths, residual, "o", ms=2.5, color=FITTED, clip_on=False)
    limit = 1.15 * max(float(np.nanmax(np.abs(residual))), 0.005)
    axes.set_ylim(-limit, limit)
    axes.set_ylabel("residual")
    wavelength_axis(axes)


def radiance_panel(axes: Axes, spectrum: VertexSpectrum) -> None:
    """Draw the radiance of one point, its diffuse part and its specular part.

    In units of the radiance of the perfect diffuser facing the first light, at
    560 nm or the middle of the bands.
    """
    wavelengths = spectrum.wavelengths
    unit = np.interp(560.0, wavelengths, spectrum.white) or spectrum.white.max()
    parts = (
        ("total", spectrum.diffuse + spectrum.specular, "-", 1.6, MEASURED),
        ("diffuse", spectrum.diffuse, "--", 1.4, FITTED),
        ("specular", spectrum.specular, ":", 1.8, SPECULAR),
    )
    for label, values, dashes, width, colour in parts:
        axes.plot(
            wavelengths, values / unit, dashes, lw=width, color=colour, label=label
        )
    axes.set_ylabel("radiance / white's")
    axes.set_ylim(0, 1.35 * float(np.max(parts[0][1] / unit)) or 1.0)
    axes.legend(loc="upper left", frameon=False, ncols=3, columnspacing=1.2)
    wavelength_axis(axes)


def wavelength_axis(axes: Axes, *, labelled: bool = True) -> None:
    """Set the wavelength axis to 400–700 nm, the visible colours under it."""
    axes.set_xlim(*_VISIBLE)
    step = 50 if inches_of(axes)[0] > _TICKS_FIT else 100
    axes.set_xticks(np.arange(400, 701, step))
    axes.grid(visible=True, color="0.92", lw=0.6)
    axes.set_axisbelow(True)
    if not labelled:
        axes.tick_params(axis="x", labelbottom=False)
        return
    strip = axes.inset_axes((0.0, 0.0, 1.0, 0.0))
    strip.set_axes_locator(partial(_under, axes))
    strip.imshow(
        spectral_colours(np.linspace(*_VISIBLE, 301))[None],
        aspect="auto",
        extent=(*_VISIBLE, 0, 1),
    )
    strip.set_axis_off()
    axes.tick_params(axis="x", length=0, pad=_STRIP + 3)
    axes.set_xlabel("wavelength (nm)", labelpad=2)


def _under(axes: Axes, *_: Any) -> Bbox:
    """Return where the strip under axes is, whatever their size has become."""
    from matplotlib.transforms import Bbox

    box = axes.get_position()
    height = _STRIP / 72 * axes.figure.dpi / axes.figure.bbox.height
    return Bbox.from_bounds(box.x0, box.y0 - height, box.width, height)


def spectral_colours(wavelengths: Array) -> Array:
    """Return display colours (n, 3) that stand for single wavelengths."""
    # Averages over neighbours round off the kinks where a display's gamut ends.
    around = np.asarray(wavelengths)[:, None] + np.linspace(-15, 15, 31)
    linear = xyz_to_linear_srgb(colour_matching_functions(np.unique(around)))
    # Spectral lights lie outside every display: add white until they fit, and
    # soften the eye's steep loss of sensitivity at both ends.
    inside = linear - np.minimum(linear.min(axis=1, keepdims=True), 0)
    strength = inside.max(axis=1, keepdims=True)
    shown = inside / strength * (strength / strength.max()) ** 0.35
    return encode_srgb(shown[np.searchsorted(np.unique(around), around)].mean(axis=1))


def swatch_colours(fit: SkinFit, measured: Array) -> tuple[Array, Array]:
    """Return the sRGB colours (3,) of measured and fitted reflectance under D65."""
    both = np.stack([measured, fit.fitted])
    xyz = spectrum_to_xyz(both, fit.wavelengths, "D65")
    first, second = encode_srgb(xyz_to_linear_srgb(xyz))
    return first, second


def weights_text(fit: SkinFit) -> str:
    """Return the weights with their 95 % intervals, one a line."""
    names = {"w_m": "melanin $w_m$", "w_h": "oxy-Hb $w_h$", "w_dh": "deoxy-Hb $w_{dh}$"}
    return "\n".join(
        f"{names.get(name, name)}  {value:.4f}  [{low:.4f}, {high:.4f}]"
        for name, value, (low, high) in zip(
            fit.parameters, fit.values, fit.interval, strict=True
        )
    )
