"""What figs 5 and 6 share: curves of both coefficient sets, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from skinviz.skin.coefficients import COEFFICIENT_SETS, load_coefficients
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS
from skinviz.view.page import Cells, lay_out
from skinviz.view.spectra_panels import Band, bands_panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def curves(names: Mapping[str, str]) -> pd.DataFrame:
    """Return curves of each set at the paper's wavelengths, one row a wavelength.

    ``names`` are attributes of :class:`Coefficients`, and their columns.
    """
    rows = []
    for name in COEFFICIENT_SETS:
        own = load_coefficients(name).at(PAPER_WAVELENGTHS)
        columns = {column: getattr(own, key) for key, column in names.items()}
        rows.append(
            pd.DataFrame(
                {"coefficients": name, "wavelength_nm": own.wavelengths, **columns}
            )
        )
    return pd.concat(rows, ignore_index=True)


def draw_curves(
    table: pd.DataFrame,
    labels: Mapping[str, str],
    width: float,
    *,
    title: str,
    caption: str,
    ylabel: str,
) -> Figure:
    """Draw a panel for each set, on one logarithmic scale; ``labels`` by column."""
    page = lay_out(
        width,
        [Cells(len(COEFFICIENT_SETS), (2.3,))],
        title=title,
        legend=list(labels.values()),
        caption=caption,
    )
    values = table[list(labels)].to_numpy()
    decades = np.log10([values.min(), values.max()])
    limits = 10 ** np.floor(decades[0]), 10 ** np.ceil(decades[1])
    for axes, (name, own) in zip(
        page.panels(), table.groupby("coefficients", sort=False), strict=True
    ):
        bands = [Band(label, own[key].to_numpy()) for key, label in labels.items()]
        handles = bands_panel(axes, own["wavelength_nm"], bands, ylabel=ylabel)
        axes.set_yscale("log")
        axes.set_ylim(*limits)
        axes.set_title(f"{name} coefficients")
    page.legend(handles, list(labels.values()))
    return page.figure
