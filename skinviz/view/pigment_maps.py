"""Maps of what was fitted to a cube of spectra, beside the cube's own colour."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.report import derived
from skinviz.skin.skin_fit import NOT_CONVERGED, REFUSED, SkinFit
from skinviz.spectra.colorimetry import (
    encode_srgb,
    xyz_to_linear_srgb,
    xyz_weights,
)
from skinviz.spectra.illuminants import illuminant_spd

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COLOURS, FLAT = "viridis", "#d9d9d9"
"""A perceptually uniform scale, and a grey that is none of its colours."""

_RC: dict[Any, Any] = {"font.size": 8, "axes.linewidth": 0.6}
_MOST = 640  # pixels of a map along its longer side: what a panel can show
_PANEL, _LOWEST, _HIGHEST = 3.0, 0.9, 4.5  # inches: width, least and most height
_BESIDE, _ABOVE = (0.42, 0.95), 0.5  # inches: left and right of a panel; above it
_WORDS, _TITLE = 0.066, 0.095  # inches: a letter of the caption; of the title
_TAIL = 0.5  # per cent of pixels beyond each end of a scale
_MANY = 1000  # pixels from which the tails are cut off


@dataclass(frozen=True, eq=False)
class _Map:
    """One quantity of the fit, with what it is called."""

    name: str
    meaning: str
    unit: str
    values: Array


def maps_figure(
    measured: NDArray[Any], fit: SkinFit, title: str, caption: str
) -> Figure:
    """Return a cube's colour, a map of each parameter, oxygen saturation and RMSE.

    Pixels that were refused or did not converge have one flat grey, and are
    counted. Of a large cube every k-th pixel is drawn, which the caption says.

    Parameters
    ----------
    measured : (line, sample, n) ndarray
        Reflectance at the fit's wavelengths; NaN where it is missing. [1]
    fit : SkinFit
        Of the cube.
    title, caption : str
        Printed above and below, wrapped.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    lines, samples = fit.status.shape
    stride = math.ceil(max(lines, samples) / _MOST)
    few = (slice(None, None, stride),) * 2
    shown = fit[few]
    maps = _maps(shown)
    colour = own_colour(measured[few], fit.wavelengths)
    tall = float(np.clip(_PANEL * lines / samples, _LOWEST, _HIGHEST))
    columns = _columns(len(maps) + 1)
    rows = math.ceil((len(maps) + 1) / columns)
    width = columns * (_PANEL + sum(_BESIDE)) + 0.1
    above = textwrap.wrap(title, int((width - 0.3) / _TITLE))
    told = f"{caption.rstrip('. ')}. {_told(fit, stride)}"
    below = textwrap.wrap(told, int((width - 0.3) / _WORDS))
    head, foot = 0.25 + 0.19 * len(above), 0.2 + 0.15 * len(below)
    height = head + rows * (tall + _ABOVE + 0.3) + foot
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(width, height), dpi=150)
        extent = (-0.5, samples - 0.5, lines - 0.5, -0.5)
        for i in range(len(maps) + 1):
            left = (i % columns) * (_PANEL + sum(_BESIDE)) + _BESIDE[0]
            top = head + (i // columns) * (tall + _ABOVE + 0.3) + _ABOVE
            box = (left, height - top - tall, _PANEL, tall)
            axes = _axes(figure, box)
            axes.set_facecolor(FLAT)
            if i == 0:
                axes.imshow(colour, extent=extent, interpolation="nearest")
                axes.set_title("colour under D65\nof the measured spectra")
            else:
                _draw(figure, axes, maps[i - 1], extent, box)
            _fit_to(axes, lines, samples)
        _say(figure, height - 0.1, above, "top", fontsize=11)
        _say(figure, 0.08, below, "bottom", fontsize=8, color="0.25")
    return figure


def own_colour(measured: NDArray[Any], wavelengths: Array) -> Array:
    """Return the sRGB colour (line, sample, 4) of spectra under D65, 2° observer.

    White, the perfect diffuser, is 1. Transparent where a band is missing.
    """
    weights = xyz_weights(wavelengths, illuminant_spd("D65", wavelengths))
    whole = np.isfinite(measured).all(axis=-1)
    xyz = np.where(whole[..., None], measured, 0.0) @ weights
    rgb = encode_srgb(xyz_to_linear_srgb(xyz))
    return np.concatenate([rgb, whole[..., None]], axis=-1)


def _maps(fit: SkinFit) -> list[_Map]:
    """Return what is drawn of a fit (line, sample), NaN where it is worth nothing."""
    numbers = derived(fit)
    failed = np.isin(fit.status, (NOT_CONVERGED, REFUSED))
    drawn = [
        _Map(p.name, p.meaning, p.unit, fit.values[..., k])
        for k, p in enumerate(fit.model.parameters)
    ]
    share = numbers["oxygen_saturation"]
    if np.isfinite(share).any():
        drawn.append(_Map("oxygen saturation", "w_h / (w_h + w_dh)", "1", share))
    drawn.append(_Map("RMSE", "measured against fitted", "1", numbers["rmse"]))
    return [
        _Map(m.name, m.meaning, m.unit, np.where(failed, np.nan, m.values))
        for m in drawn
    ]


def _told(fit: SkinFit, stride: int) -> str:
    """Return what a reader of the maps must know."""
    n = fit.status.size
    lines, samples = fit.status.shape
    refused, wandering = (
        int((fit.status == status).sum()) for status in (REFUSED, NOT_CONVERGED)
    )
    told = (
        f"{lines} × {samples} pixels. Grey: {refused} of {n} refused and {wandering} "
        "not converged; in the oxygen saturation also those without blood."
    )
    if n > _MANY:
        told += f" Scales leave out {_TAIL:g} % of the pixels at each end."
    if stride > 1:
        told += f" Drawn: one pixel in {stride} of one line in {stride}."
    return told


def _draw(
    figure: Figure,
    axes: Axes,
    one: _Map,
    extent: tuple[float, float, float, float],
    box: tuple[float, float, float, float],
) -> None:
    """Draw one map and its scale."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    known = one.values[np.isfinite(one.values)]
    axes.set_title(
        "\n".join([one.name, *textwrap.wrap(one.meaning, 46)[:2]]), parse_math=False
    )
    if known.size == 0:
        axes.imshow(one.values, extent=extent, alpha=0.0)
        axes.text(0.5, 0.5, "no pixel fitted", transform=axes.transAxes, ha="center")
        return
    tail = _TAIL if known.size > _MANY else 0.0
    low, high = np.percentile(known, [tail, 100 - tail])
    beyond = {(True, True): "both", (True, False): "min", (False, True): "max"}
    ends = beyond.get((known.min() < low, known.max() > high), "neither")
    if high - low <= 1e-9 * max(abs(low), 1e-6):  # one value all over
        low, high = low - 0.05 * max(abs(low), 0.01), high + 0.05 * max(abs(high), 0.01)
    scale = Normalize(low, high)
    axes.imshow(
        np.ma.masked_invalid(one.values),
        cmap=COLOURS,
        norm=scale,
        extent=extent,
        interpolation="nearest",
    )
    left, bottom, wide, tall = box
    bar = _axes(figure, (left + wide + 0.08, bottom, 0.11, tall))
    figure.colorbar(ScalarMappable(scale, COLOURS), cax=bar, extend=ends)
    bar.set_ylabel(f"{one.name} [{one.unit}]", fontsize=7.5, parse_math=False)
    bar.tick_params(labelsize=7)


def _fit_to(axes: Axes, lines: int, samples: int) -> None:
    """Keep pixels square unless the cube is far longer than wide, or wider."""
    square = _PANEL * lines / samples
    stretched = square < _LOWEST / 2 or square > 2 * _HIGHEST
    axes.set_aspect("auto" if stretched else "equal", anchor="C")
    axes.locator_params(nbins=4, integer=True)
    axes.tick_params(labelsize=7, length=2)


def _columns(n: int) -> int:
    """Return how many of n panels stand side by side: three or four, rows full."""
    return min((3, 4), key=lambda columns: -n % columns)


def _axes(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Return axes at a place in inches from the lower left."""
    width, height = figure.get_size_inches()
    left, bottom, wide, tall = box
    return figure.add_axes((left / width, bottom / height, wide / width, tall / height))


def _say(figure: Figure, at: float, lines: list[str], edge: str, **how: Any) -> None:
    """Write lines at the left, an edge of them at some inches from the bottom."""
    width, height = figure.get_size_inches()
    text = "\n".join(lines)
    figure.text(0.1 / width, at / height, text, va=edge, parse_math=False, **how)
