"""Weights measured at a few points of a hand, spread over its surface."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, one_of
from skinviz.errors import ArgumentError, MeshError
from skinviz.scene.geodesics import Surface, surface_of
from skinviz.scene.landmarks import GROUPS, NAMES, landmarks

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
Point = str | int | tuple[float, float, float]

_FARTHEST = 5.0  # mm, from the mesh, that a point may be given
_BEND = 15.0  # mm, over which a map bends at a point; farther away it is a membrane
_SUM = 1e-3  # by which shares may miss 1 before they are scaled to it
_SMALLEST_AREA = 1e-9  # mm²
_SOFT = 0.05  # of a point's share, below which it fades out


def pigment_map(
    mesh: pyvista.PolyData,
    points: Mapping[Point, ArrayLike],
    surface: Surface | None = None,
) -> Array:
    """Spread parameters given at a few points over a mesh, along its surface.

    Parameters
    ----------
    mesh : pyvista.PolyData
        [mm] A hand, where points are named.
    points : mapping
        From a point to its parameters (p,). A point is a name of :func:`landmarks`
        (``"back"``, ``"index_knuckle"``), a name for several of them (``"knuckle"``,
        ``"palm_side"``; those excepted that a narrower name has), a vertex's number,
        or coordinates ``(x, y, z)``. [mm]
    surface : Surface, optional
        Of the mesh, where it is at hand.

    Returns
    -------
    values : (n_points, p) ndarray
        At the points exactly what is given there, elsewhere a mean of it.

    Raises
    ------
    ArgumentError
        If a name is unknown, a point is no vertex's or too far from the mesh, two
        points are at one vertex, or parameters are not finite numbers.
    MeshError
        If points are named and the mesh is not a hand.

    Notes
    -----
    Each point has a share of each vertex: the smoothest field on the surface that is
    1 at this point and 0 at the others, by the energy ∫ |∇f|² + ℓ² (Δf)² with ℓ = 15
    mm, a spline in tension [1]_. Shares below 0, which splines have, are faded out,
    and their sum is made 1. So a map is exact at its points, lies between the
    smallest and the largest given, positive where they are, and has a continuous
    gradient. A mean by inverse distance (Shepard's) would be flat round each point, a
    visible disc. A piece of the mesh without a point has what the nearest vertex of
    another piece has.

    References
    ----------
    .. [1] P. Wessel and D. Bercovici, Mathematical Geology 30:77 (1998), in the plane;
       here with the surface's Laplacian by cotangents.
    """
    if not points:
        raise ArgumentError("a pigment map needs at least one point")
    surface = surface or surface_of(mesh)
    sites = vertices_of(mesh, list(points), surface)
    rows = [as_numbers(points[key], f"pigments at {key!r}") for key, _ in sites]
    if len({row.shape for row in rows}) != 1 or rows[0].ndim != 1:
        raise ArgumentError(
            "pigments at each point must be as many numbers; got shapes "
            f"{', '.join(str(row.shape) for row in rows)}"
        )
    values = np.array(rows)
    if not np.isfinite(values).all():
        raise ArgumentError("pigments at points must be finite; remove NaN or infinity")
    return spread(surface, np.array([vertex for _, vertex in sites]), values)


def vertices_of(
    mesh: pyvista.PolyData, points: Sequence[Point], surface: Surface
) -> list[tuple[Point, int]]:
    """Return the vertices at which points are, each with the point that says so."""
    named = [key for key in points if isinstance(key, str)]
    for name in named:
        one_of(name, (*NAMES, *GROUPS), "point of a hand")
    places = landmarks(mesh, surface) if named else {}
    single: dict[str, str] = {}
    for name in sorted(named, key=lambda name: -len(GROUPS.get(name, (name,)))):
        single |= dict.fromkeys(GROUPS.get(name, (name,)), name)
    sites: list[tuple[Point, int]] = [
        (key, places[place]) for place, key in single.items()
    ]
    sites += [(key, _vertex(key, surface)) for key in points if key not in named]
    taken: dict[int, Point] = {}
    for key, vertex in sites:
        if vertex in taken:
            raise ArgumentError(
                f"the points {taken[vertex]!r} and {key!r} are at the same vertex, "
                f"{vertex}; leave one out"
            )
        taken[vertex] = key
    return sites


def spread(surface: Surface, sites: Whole, values: Array) -> Array:
    """Return values (k, p), given at vertices (k,), at all vertices (n, p)."""
    known = np.isin(surface.pieces, surface.pieces[sites])
    shares = np.zeros((len(known), len(sites)))
    shares[sites, np.arange(len(sites))] = 1.0
    free = known.copy()
    free[sites] = False
    shares[free] = _faded(_smoothest(surface, sites, np.flatnonzero(free)))
    low, high = values.min(axis=0), values.max(axis=0)
    out = np.clip(shares @ values, low, high)  # beyond which sums go by rounding
    if not known.all():
        _, nearest = surface.nearest_of(np.flatnonzero(known), surface.points[~known])
        out[~known] = out[nearest]
    return out


def _smoothest(surface: Surface, sites: Whole, free: Whole) -> Array:
    """Return the field of each site at other vertices (m, k): 1 at it, 0 at others."""
    from scipy.sparse import diags
    from scipy.sparse.linalg import splu

    if free.size == 0:
        return np.zeros((0, len(sites)))
    stretch, area = surface.laplacian, np.maximum(surface.areas, _SMALLEST_AREA)
    energy = (stretch + _BEND**2 * stretch @ diags(1 / area) @ stretch).tocsc()
    rows = energy[free]
    try:
        factors = splu(
            rows[:, free].tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        fields = np.asarray(factors.solve(-rows[:, sites].toarray()))
    except RuntimeError:  # it is exactly singular
        fields = np.full((free.size, len(sites)), np.nan)
    # A wrong solution is told by this: all fields together are 1 everywhere.
    if not np.abs(fields.sum(axis=1) - 1).max() < _SUM:
        raise MeshError(
            "the mesh's triangles are too thin to spread pigments over; clean it "
            "first: skinviz clean"
        )
    return fields


def _faded(fields: Array) -> Array:
    """Return shares (m, k) that are not negative, their sums 1, without a kink."""
    ramp = np.clip(fields, 0, _SOFT)
    shares = ramp**2 / (2 * _SOFT) + np.maximum(fields - _SOFT, 0)
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def _vertex(point: Hashable, surface: Surface) -> int:
    """Return the vertex that a number or coordinates say."""
    n = len(surface.points)
    if isinstance(point, int | np.integer) and not isinstance(point, bool):
        if not 0 <= point < n:
            raise ArgumentError(
                f"vertex {point} is none of the mesh's {n}, 0 to {n - 1}"
            )
        return int(point)
    place = as_numbers(point, "a point")  # type: ignore[arg-type]
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ArgumentError(
            "a point must be a name, a vertex's number or three coordinates in mm; got "
            f"{point!r}"
        )
    distance, vertex = surface.nearest_of(np.unique(surface.faces), place)
    if distance > _FARTHEST:
        raise ArgumentError(
            f"the point {point} is {distance:.3g} mm from the mesh; at most "
            f"{_FARTHEST:g} mm: give coordinates of the mesh, in mm"
        )
    return int(vertex)
