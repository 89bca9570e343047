"""The measured trade of speed for accuracy: what ways to a picture cost and change."""

from __future__ import annotations

import contextlib
import dataclasses
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz.errors import ArgumentError, SceneWarning
from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.rendering.plan import MOST_SAMPLES, SPECTRA, Plan
from skinviz.rendering.render import Rendering, render
from skinviz.rendering.spectral import light_spectra, white_xyz
from skinviz.rendering.tolerance import FEW, Difference, compare
from skinviz.rendering.ways import REFERENCE, Way, ways
from skinviz.scene.scene import Scene

Array = NDArray[np.float64]

RUNS = 3
"""Times that a picture is computed, of which the shortest counts."""

_PATIENCE = 2.0  # s, after which a picture is not computed once more
_ROWS = 8  # of the picture, whose spectra are compared
_WARM = 16  # pixels of the picture that compiles what is not


@dataclass(frozen=True)
class Trade:
    """What one way to a picture costs, and how far it is from the reference.

    Attributes
    ----------
    way : Way
        The way.
    ms : float or None
        Shortest time of a picture, planning apart; None if it cannot be had. [ms]
    difference : Difference or None
        Of its colours from the reference's.
    spectral_rmse : float or None
        Root mean square difference of radiance on the scene's bands, over some pixels
        that the mesh fills, as a share of the white's; None where the lamps do not
        cover these bands. [1]
    on_front : bool
        Whether it keeps its edges, and no other such way is faster with as small a
        99th percentile of ΔE00 over filled pixels, or better and as fast.
    note : str
        Why it, or its spectra, cannot be had.
    """

    way: Way
    ms: float | None = None
    difference: Difference | None = None
    spectral_rmse: float | None = None
    on_front: bool = False
    note: str = ""

    @property
    def edges_kept(self) -> bool:
        """Whether edges are as the tolerance allows that filled pixels just keep."""
        off = self.difference
        if off is None:
            return False
        return off.kept(off.most_filled if off.n_filled < FEW else off.filled)

    @property
    def kept(self) -> bool | None:
        """Whether what it was planned for is kept; None if it was not planned."""
        if self.difference is None or self.way.tolerance is None:
            return None
        return self.difference.kept(self.way.tolerance)


@dataclass(frozen=True, eq=False)
class _Truth:
    """What pictures are compared with."""

    picture: Rendering
    white: Array
    spectra: _Spectra | None
    note: str


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Radiance (k, bands) of some pixels that the mesh fills.

    ``filled`` are its pixels in each of some rows, ``scale`` is the white's root mean
    square.
    """

    filled: dict[int, NDArray[np.bool_]]
    radiance: Array
    scale: float

    def rmse(self, picture: Rendering) -> float:
        """Return how far a picture's spectra are from these. [1]"""
        # The scale comes first: light may be as large as float32 holds.
        off = (_radiance(picture, self.filled) - self.radiance) / self.scale
        return float(np.sqrt(np.mean(off**2)))


def tradeoff(
    scene: Scene,
    tried: Sequence[Way] | None = None,
    *,
    geometry: Geometry | None = None,
    advance: Callable[[int], object] | None = None,
) -> list[Trade]:
    """Measure what ways to a scene's picture cost and change.

    Parameters
    ----------
    scene : Scene
        What is to be shown.
    tried : sequence of Way, optional
        The ways, the reference among them; those of :func:`ways` by default.
    geometry : Geometry, optional
        Of the scene's mesh, where it is at hand.
    advance : callable, optional
        Told that one more way is measured, as it is.

    Returns
    -------
    trades : list of Trade
        One a way, in their order.

    Raises
    ------
    ArgumentError
        If the scene cannot be rendered, or no skin is lit and seen in it.

    Notes
    -----
    Times are of :func:`render`, the mesh made ready before: the shortest of three, or
    of fewer where these take over two seconds. They are of this machine as it is: let
    nothing else run.
    """
    geometry = geometry or geometry_of(scene.mesh)
    tried = ways(scene, geometry=geometry) if tried is None else tried
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        _warm_up(scene, geometry, tried)
        measure = _Meter(scene, geometry)
        trades = []
        for way in tried:
            trades.append(measure(way))
            if advance is not None:
                advance(1)
    return _with_front(trades)


def front(cost: ArrayLike, error: ArrayLike) -> NDArray[np.bool_]:
    """Return which points (n,) none other beats in one way and equals in the other.

    Points with NaN are not on it.
    """
    cost, error = np.asarray(cost, np.float64), np.asarray(error, np.float64)
    on_it = np.zeros(cost.size, dtype=bool)
    least = (np.inf, np.inf)
    for i in np.lexsort((error, cost)):
        own = (error[i], cost[i])
        if np.isfinite(own).all() and (own[0] < least[0] or own == least):
            least, on_it[i] = own, True
    return on_it


class _Meter:
    """Measures ways of one scene, each picture once."""

    def __init__(self, scene: Scene, geometry: Geometry) -> None:
        """Compute the reference."""
        self._scene, self._geometry = scene, geometry
        self._known: dict[Plan, Trade] = {}
        picture, self._reference_ms = self._timed(Plan())
        self._truth = _truth_of(picture)

    def __call__(self, way: Way) -> Trade:
        """Return what a way costs and changes."""
        if way.setting not in self._known:
            self._known[way.setting] = self._measured(way)
        return dataclasses.replace(self._known[way.setting], way=way)

    def _measured(self, way: Way) -> Trade:
        """Return the same, of a picture that was not computed before."""
        if way.group == REFERENCE:
            picture, ms = self._truth.picture, self._reference_ms
        else:
            try:
                picture, ms = self._timed(way.setting)
            except ArgumentError as error:
                return Trade(way, note=str(error))
        truth = self._truth
        difference = compare(
            picture.xyz, truth.picture.xyz, truth.picture.covered, truth.white
        )
        rmse = None if truth.spectra is None else truth.spectra.rmse(picture)
        return Trade(way, ms, difference, rmse, note=truth.note)

    def _timed(self, plan: Plan) -> tuple[Rendering, float]:
        """Return a picture and its time. [ms]"""
        times: list[float] = []
        while len(times) < RUNS and sum(times) < _PATIENCE:
            begun = time.perf_counter()
            picture = render(self._scene, plan, geometry=self._geometry)
            times.append(time.perf_counter() - begun)
        return picture, 1e3 * min(times)


def _warm_up(scene: Scene, geometry: Geometry, tried: Sequence[Way]) -> None:
    """Draw small pictures, so that no time is of compiling or of Embree's tree."""
    camera = dataclasses.replace(scene.camera, size=(_WARM, _WARM))
    small = scene.replace(camera=camera)
    kinds = {_kind(way.setting): None for way in tried}  # each once, in order
    for plan in kinds:
        with contextlib.suppress(ArgumentError):  # told where it is measured
            render(small, plan, geometry=geometry).radiance((0, 0))


def _kind(plan: Plan) -> Plan:
    """Return a quick plan that runs through the same code."""
    return plan.replace(
        samples=min(plan.samples, 4),
        refine=None if plan.refine is None else 1.0,
        bounce_rays=min(plan.bounce_rays, 16),
        spectrum=SPECTRA[0],
    )


def _truth_of(picture: Rendering) -> _Truth:
    """Return what others are compared with, or say that there is nothing."""
    lit = (picture.covered > 0) & (picture.xyz[..., 1] > 0)
    if not lit.any():
        why = picture.notes[0] if picture.notes else "nothing of the mesh is lit"
        raise ArgumentError(
            f"there is no light to compare: {why}; change the lights or the view"
        )
    white = white_xyz(picture.scene)
    full = (picture.covered == MOST_SAMPLES) & lit
    chosen = full if full.any() else lit
    try:
        return _Truth(picture, white, _spectra(picture, chosen), "")
    except ArgumentError as error:
        return _Truth(picture, white, None, str(error))


def _spectra(picture: Rendering, chosen: NDArray[np.bool_]) -> _Spectra:
    """Return the spectra of chosen pixels (height, width), in some of the rows."""
    scale = float(np.sqrt(np.mean(light_spectra(picture.scene)[0] ** 2)))
    which = np.flatnonzero(chosen.any(axis=1))
    some = which[np.linspace(0, which.size - 1, min(_ROWS, which.size)).astype(int)]
    filled = {int(row): chosen[row] for row in some}
    return _Spectra(filled, _radiance(picture, filled), scale)


def _radiance(picture: Rendering, filled: dict[int, NDArray[np.bool_]]) -> Array:
    """Return the radiance (k, bands) of some pixels of some rows."""
    width = picture.size[0]
    return np.concatenate(
        [
            picture.radiance((0, row, width, row + 1))[0][own].astype(np.float64)
            for row, own in filled.items()
        ]
    )


def _with_front(trades: list[Trade]) -> list[Trade]:
    """Return trades that know whether they are on the front."""
    cost = [t.ms if t.ms is not None and t.edges_kept else np.nan for t in trades]
    error = [np.nan if t.difference is None else t.difference.filled for t in trades]
    on_it = front(cost, error)
    return [
        dataclasses.replace(trade, on_front=bool(best))
        for trade, best in zip(trades, on_it, strict=True)
    ]
