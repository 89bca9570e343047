"""Hands in the skin of each level of a comparison, side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skinviz.errors import SkinvizError
from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh, read_scan
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scene.camera import Camera
from skinviz.scene.hand import hand_frame
from skinviz.scene.lights import DirectionalLight
from skinviz.scene.scene import Scene, Skin
from skinviz.study.comparison import Cell, Comparison
from skinviz.study.study import Study
from skinviz.surface.gonio import read_gonio
from skinviz.surface.lobe_fit import fit_lobe
from skinviz.surface.surface import Surface
from skinviz.surface.torrance_sparrow import TorranceSparrow
from skinviz.view.comparison_colours import colours_within
from skinviz.view.comparison_levels import (
    WIDTH,
    drawn,
    error_text,
    shortened,
    shown,
    title_of,
)
from skinviz.view.hands_grid import Hand, grid_figure, render_linked

if TYPE_CHECKING:
    import pyvista
    from matplotlib.figure import Figure

LIGHT = 30.0
"""Angle of the light from the normal of the hand's back; the viewer is at 0. [°]"""

_SIZE = (480, 640)  # pixels of a picture
_MARGIN, _WIDEST = 0.4, 2.4  # inches: of the figure; a hand
_MOST_BESIDE = 6  # hands in a row


@dataclass(frozen=True, eq=False)
class Hands:
    """A figure of hands, and what could not be had for it."""

    figure: Figure
    notes: tuple[str, ...]


def comparison_hands(
    comparison: Comparison,
    caption: str = "",
    *,
    illuminant: str = "D65",
    width: float = WIDTH,
    advance: Callable[[int], None] | None = None,
) -> Hands:
    """Return hands in each level's skin, under one light, at one scale and exposure.

    The skin is the fit of the level's mean spectrum, whatever site it is of. The hand
    is the subject's own where a level is one subject's, and the surface's lobe too;
    else the hand that comes with skinviz.

    Parameters
    ----------
    comparison : Comparison
        Of which the first levels are drawn, as in its other figures.
    caption : str
        Where the data come from.
    illuminant : str
        Name of the light's spectrum.
    width : float
        Of the figure. [inches]
    advance : callable, optional
        Told 1 for each picture that is done.

    Returns
    -------
    hands : Hands
        With notes on meshes and readings that could not be used.

    Raises
    ------
    SkinvizError
        If no mean spectrum was fitted.
    """
    cells = [
        cell
        for stratum in comparison.strata
        for cell in drawn(comparison, stratum)
        if cell.is_fitted
    ]
    if not cells:
        raise SkinvizError("no level's mean spectrum was fitted: there is no skin")
    maker = _Maker(comparison.study, comparison.by, illuminant)
    scenes = [maker.scene(cell) for cell in cells]
    pictures = render_linked(scenes, advance=advance)
    hands = {
        (cell.stratum, cell.level): Hand(
            picture.rgb,
            label=shortened(cell.level),
            swatches=list(colours_within(cell)),
            notes=[error_text(cell)],
        )
        for cell, picture in zip(cells, pictures, strict=True)
    }
    rows, names = [], []
    for stratum in comparison.strata:
        for levels in _rows(shown(comparison)):  # a level has its column in all strata
            row = [hands.get((stratum, level)) for level in levels]
            if any(row):
                rows.append(row)
                names.append(title_of(stratum))
    words = (
        f"The skin fitted to each mean spectrum on {maker.told}, light {illuminant} at "
        f"{LIGHT:g}°, one scale and exposure. Swatches: the fit under D65, its "
        "estimate between the ends of the 95 % that its covariance allows, by Monte "
        f"Carlo. {caption}"
    )
    figure = grid_figure(
        rows,
        min(width, _MARGIN + _WIDEST * len(rows[0])),
        pixel=pictures[0].view.pixel,
        row_labels=names if any(names) else (),
        title=f"Hands by {comparison.by}",
        caption=words,
    )
    return Hands(figure, tuple(maker.notes))


class _Maker:
    """Makes the scene of a cell; loads each mesh and fits each lobe once."""

    def __init__(self, study: Study, by: str, illuminant: str) -> None:
        """Take what all scenes share."""
        self._study, self._by, self._illuminant = study, by, illuminant
        self._meshes: dict[str, pyvista.PolyData] = {}
        self._surfaces: dict[tuple[str, str], Surface] = {}
        self.notes: list[str] = []

    @property
    def told(self) -> str:
        """On whose hands the skin is, in words."""
        own = [name for name in self._meshes if name]
        shipped = ["the MakeHuman hand (CC0)"] if "" in self._meshes else []
        return " and ".join(
            [*([f"the own hands of {', '.join(own)}"] if own else []), *shipped]
        )

    def scene(self, cell: Cell) -> Scene:
        """Return the scene of a cell's skin."""
        subject = cell.level if self._by == "subject" else ""
        if not subject and len(cell.units) == 1:
            subject = cell.units[0]
        mesh = self._mesh(subject if subject in self._study.shapes else "")
        frame = hand_frame(mesh)
        light = frame.direction(np.deg2rad(LIGHT))
        return Scene(
            mesh=mesh,
            skin=Skin.from_fit(cell.fit),
            surface=self._surface(subject, cell.site),
            lights=(DirectionalLight(light, self._illuminant),),
            camera=Camera(frame.back, frame.fingers, _SIZE),
        )

    def _mesh(self, subject: str) -> pyvista.PolyData:
        """Return a subject's hand, the shipped one for "" or if it cannot be used."""
        if subject not in self._meshes:
            if not subject:
                self._meshes[""] = read_mesh(shipped_mesh(TRUE_SHAPE), "m")
                return self._meshes[""]
            shape = self._study.shapes[subject]
            try:
                if shape.raw:
                    mesh, _ = clean_scan(read_scan(shape.path, unit=shape.unit))
                else:
                    mesh = read_mesh(shape.path, shape.unit)
                hand_frame(mesh)
            except SkinvizError as error:
                self.notes.append(f"the hand of {subject} is not used: {error}")
                return self._mesh("")
            self._meshes[subject] = mesh
        return self._meshes[subject]

    def _surface(self, subject: str, site: str) -> Surface:
        """Return the lobe fitted to a subject's readings, the usual one without."""
        gonio = self._study.gonio
        key = (subject, site) if (subject, site) in gonio else (subject, "")
        if key not in gonio:
            return TorranceSparrow()
        if key not in self._surfaces:
            try:
                read = read_gonio(gonio[key])
                lobe = fit_lobe(
                    read.illumination,
                    read.specular,
                    viewing=read.viewing,
                    uncertainty=read.uncertainty,
                )
                self._surfaces[key] = lobe.surface
            except SkinvizError as error:
                self.notes.append(f"the readings of {subject} are not used: {error}")
                self._surfaces[key] = TorranceSparrow()
        return self._surfaces[key]


def _rows(levels: Sequence[str]) -> list[list[str]]:
    """Return levels in rows of like length, the last filled up with ""."""
    n_rows = -(-len(levels) // _MOST_BESIDE)
    beside = -(-len(levels) // n_rows)
    filled = [*levels, *[""] * (n_rows * beside - len(levels))]
    return [filled[i : i + beside] for i in range(0, len(filled), beside)]
