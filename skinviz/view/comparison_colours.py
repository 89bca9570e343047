"""The figure of a comparison's colours: swatches with their uncertainty, ΔE00."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.spectra.colorimetry import lab_to_xyz, spectrum_to_xyz
from skinviz.study.comparison import Cell, Comparison
from skinviz.view.comparison_levels import (
    WIDTH,
    drawn,
    error_text,
    shortened,
    shown,
    title_of,
)
from skinviz.view.delta_e_matrix import delta_e_matrix, matrix_cells
from skinviz.view.page import STYLE, Cells, Margins, lay_out
from skinviz.view.spectra_panels import ROW, Swatch, srgb_of, swatch_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_NORMAL = 1.96  # standard deviations on either side that hold 95 %


def colours_figure(
    comparison: Comparison, caption: str = "", width: float = WIDTH
) -> Figure:
    """Return each level's colour with its uncertainty, and ΔE00 between levels."""
    import matplotlib as mpl

    strata, levels = comparison.strata, shown(comparison)
    most = max(len(drawn(comparison, stratum)) for stratum in strata)
    wide = 2.7
    blocks = [
        Cells(
            len(strata),
            (1.4 * ROW * most,),
            least=wide,
            margins=Margins(left=0.05, right=0.2, top=0.26, bottom=0.08),
        )
    ]
    if comparison.colours:
        blocks.append(matrix_cells(len(strata), [shortened(level) for level in levels]))
    words = (
        "Swatches: measured, then fitted: the estimate between both ends of the "
        "95 % that the fit's covariance allows, by Monte Carlo; ± is within which "
        "ΔE00 of the estimate 95 % of the draws lie. Numbers are the fit's. "
    )
    if comparison.colours:
        words += (
            "Matrix: ΔE00 of the mean spectra, above the diagonal as measured, below "
            "it as fitted, with the 95 % interval of both fits' covariances. "
        )
    with mpl.rc_context(STYLE):
        page = lay_out(
            width,
            blocks,
            title=f"Colours under D65 by {comparison.by}",
            caption=words + caption,
        )
        for stratum, axes in zip(strata, page.panels(0), strict=True):
            cells = drawn(comparison, stratum)
            axes.set_title(title_of(stratum), parse_math=False, loc="left")
            swatch_rows(axes, [_swatch(cell) for cell in cells])
            axes.set_ylim(most, 0)
        if comparison.colours:
            for stratum, axes in zip(strata, page.panels(1), strict=True):
                own = [c for c in comparison.colours if c.stratum == stratum]
                delta_e_matrix(
                    axes, own, levels, [shortened(level) for level in levels]
                )
                axes.set_title(
                    ", ".join(filter(None, ("ΔE00", title_of(stratum)))),
                    parse_math=False,
                )
    return page.figure


def _swatch(cell: Cell) -> Swatch:
    """Return a cell's colour as measured and as fitted, with what it may be."""
    parts = [srgb_of(np.nan_to_num(cell.fit.xyz[0]))]
    if cell.is_fitted:
        parts += list(colours_within(cell))
    return Swatch(
        label=f"{shortened(cell.level)} (n = {len(cell.units)})",
        rgb=np.array(parts),
        lab=cell.colour.lab if cell.is_fitted else None,
        note=error_text(cell),
    )


def colours_within(cell: Cell) -> Array:
    """Return sRGB (3, 3) of a fit: its estimate between the ends of what it may be."""
    colour, bands = cell.colour, cell.fit.wavelengths
    covariance = colour.covariance
    end = np.zeros(3)
    if np.isfinite(covariance).all():
        variances, axes = np.linalg.eigh(covariance)
        axis = axes[:, -1] * np.copysign(1.0, axes[0, -1])  # the lighter end last
        end = _NORMAL * np.sqrt(max(variances[-1], 0.0)) * axis
    white = spectrum_to_xyz(np.ones(bands.size), bands)
    xyz = lab_to_xyz(colour.lab + np.array([[-1.0], [0.0], [1.0]]) * end, white)
    return srgb_of(np.maximum(xyz, 0))
