"""A figure of a scan before and after cleaning, with what is wrong marked on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError
from skinviz.scan import topology
from skinviz.scan.caster import Caster
from skinviz.scan.scan import Scan, transform
from skinviz.scan.topology import Faces, Points
from skinviz.scan.views import view_surface
from skinviz.scan.wrist import wrist_loop
from skinviz.scene.hand import hand_frame

if TYPE_CHECKING:
    import pyvista
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_HOLE, _WRIST, _BAD = "#d62728", "#1f5fbf", "#c000c0"
_SKIN = np.array([0.80, 0.78, 0.74])
_PIXELS = 700  # of a panel's longer side
_MARGIN = 4.0  # mm
_LIFT = 1.5  # mm towards the viewer: clear of an edge's own faces
_NEAR = 2.0  # mm: a rim that another view covers is no hole
_RC: dict[Any, Any] = {"font.size": 9, "legend.fontsize": 9}


@dataclass(frozen=True)
class _Drawn:
    """A surface to draw and the edges (k, 2) to mark on it, by kind."""

    title: str
    points: Points
    faces: Faces
    holes: NDArray[np.int64]
    wrist: NDArray[np.int64]
    bad: NDArray[np.int64]


def scan_preview(scan: Scan, cleaned: pyvista.PolyData) -> Figure:
    """Return back and palm of a scan as it came and as it was cleaned.

    Marked are the outlines of holes, the wrist's opening and the edges that more
    than two faces share. Of range views, a rim that no other view covers, by the
    poses in the file, counts as a hole's.

    Parameters
    ----------
    scan : Scan
        Raw views, a mesh or points. [mm]
    cleaned : pyvista.PolyData
        What cleaning made of it. [mm]
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    points, faces = topology.arrays(cleaned)
    axes = _axes(cleaned)
    palm = axes * np.array([[-1], [1], [-1]])
    low, high = _extent(points, axes)
    after = _mesh("After", points, faces)
    surfaces = [_before(scan), after]
    wide, tall = (high - low)[:2]
    with mpl.rc_context(_RC):
        panel = 4.3 * wide / tall
        figure = Figure(figsize=(4 * panel + 0.5, 5.3), dpi=150)
        grid = figure.subplots(1, 4, gridspec_kw={"wspace": 0.03})
        figure.subplots_adjust(left=0.01, right=0.99, bottom=0.10, top=0.88)
        for surface, pair in zip(surfaces, (grid[:2], grid[2:]), strict=True):
            caster = Caster(surface.points, surface.faces)
            for ax, turned, side in zip(
                pair, (axes, palm), ("back", "palm"), strict=True
            ):
                _panel(ax, surface, caster, turned, _extent(points, turned))
                ax.set_xlabel(side, labelpad=2)
            head = (pair[0].get_position().x0 + pair[1].get_position().x1) / 2
            figure.text(head, 0.955, surface.title, ha="center", fontsize=11)
            figure.text(head, 0.91, _counts(surface), ha="center", color="0.3")
        _legend(figure)
        _scale_bar(grid[3], *_extent(points, palm))
    return figure


def _mesh(title: str, points: Points, faces: Faces) -> _Drawn:
    """Return a mesh with its boundary and non-manifold edges."""
    edges, counts = topology.edge_counts(faces)
    boundary = edges[counts == 1]
    loop = wrist_loop(points, faces)
    none = np.zeros(0, dtype=np.int64)
    of_wrist = np.asarray(np.isin(boundary, none if loop is None else loop).all(axis=1))
    return _Drawn(
        title,
        points,
        faces,
        boundary[~of_wrist],
        boundary[of_wrist],
        edges[counts > 2],
    )


def _before(scan: Scan) -> _Drawn:
    """Return what came, as it lies before cleaning."""
    from scipy.spatial import cKDTree

    if scan.mesh is not None:
        return _mesh("Before: the mesh as it came", *topology.arrays(scan.mesh))
    if not scan.views:
        raise MeshError(
            f"{scan.source or 'scan'} has bare points, of which no surface can be "
            "drawn; leave the preview out"
        )
    made = [view_surface(view, max_stretch=6.0, rim_rings=0) for view in scan.views]
    placed = [
        transform(view.pose, points)
        for view, (points, _, _) in zip(scan.views, made, strict=True)
    ]
    rims = [topology.boundary_edges(own) for _, own, _ in made]
    trees = [
        cKDTree(np.delete(at, np.unique(rim), axis=0))
        for at, rim in zip(placed, rims, strict=True)
    ]
    faces, holes, count = [], [], 0
    for i, (at, (_, own, _), rim) in enumerate(zip(placed, made, rims, strict=True)):
        middle = at[rim].mean(axis=1)
        others = [tree for k, tree in enumerate(trees) if k != i]
        gaps = [tree.query(middle, distance_upper_bound=_NEAR)[0] for tree in others]
        covered = np.any([np.asarray(gap) < _NEAR for gap in gaps], axis=0)
        covered = np.broadcast_to(covered, len(rim))
        faces.append(own + count)
        holes.append(rim[~covered] + count)
        count += len(at)
    none = np.zeros((0, 2), dtype=np.int64)
    title = f"Before: {len(made)} raw views, placed as the file says"
    every = np.concatenate(holes)
    return _Drawn(
        title, np.concatenate(placed), np.concatenate(faces), every, none, none
    )


def _counts(surface: _Drawn) -> str:
    """Return what is marked on a surface, in words."""
    told = []
    if surface.wrist.size or surface.bad.size or not surface.holes.size:
        n_holes = len(_loops(surface.holes))
        told.append(f"{n_holes} hole{'' if n_holes == 1 else 's'}")
        told.append(f"{len(surface.bad)} non-manifold edges")
        told.append(f"{len(surface.faces):,} triangles")
    else:
        told.append(f"{len(surface.faces):,} triangles, overlapping")
    return ", ".join(told)


def _loops(edges: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return the points of each connected set of edges."""
    if len(edges) == 0:
        return []
    used, local = np.unique(edges, return_inverse=True)
    labels = topology.components(used.size, local.reshape(-1, 2))
    return [used[labels == label] for label in range(labels.max() + 1)]


def _axes(mesh: pyvista.PolyData) -> Array:
    """Return rows right, up and towards the viewer of the back; fingers up."""
    try:
        frame = hand_frame(mesh)
    except MeshError:  # no hand that could be told
        points = np.asarray(mesh.points, dtype=np.float64)
        _, own = np.linalg.eigh(np.cov(points.T))
        return np.array([own[:, 1], own[:, 2], np.cross(own[:, 1], own[:, 2])])
    return np.array([frame.side, frame.fingers, frame.back])


def _extent(points: Points, axes: Array) -> tuple[Array, Array]:
    """Return the corners of the box around points along axes, with a margin."""
    local = points @ axes.T
    return local.min(axis=0) - _MARGIN, local.max(axis=0) + _MARGIN


def _panel(
    ax: Axes, surface: _Drawn, caster: Caster, axes: Array, bounds: tuple[Array, Array]
) -> None:
    """Draw a surface from one side, and what is marked on it and in sight."""
    from matplotlib.collections import LineCollection

    low, high = bounds
    ax.imshow(
        _shaded(caster, axes, low, high),
        extent=(low[0], high[0], low[1], high[1]),
        origin="lower",
        interpolation="antialiased",
    )
    marks = (
        (surface.wrist, _WRIST, 1.8),
        (surface.holes, _HOLE, 1.3),
        (surface.bad, _BAD, 2.6),
    )
    for edges, colour, width in marks:
        lines = _in_sight(surface.points, edges, caster, axes)
        ax.add_collection(
            LineCollection(
                list(lines), colors=colour, linewidths=width, capstyle="round"
            )
        )
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)


def _shaded(caster: Caster, axes: Array, low: Array, high: Array) -> Array:
    """Return a picture (rows, columns, 3) lit from the viewer's upper left."""
    step = float((high - low)[:2].max()) / _PIXELS
    x = np.arange(low[0] + step / 2, high[0], step)
    y = np.arange(low[1] + step / 2, high[1], step)
    grid = np.stack([*np.meshgrid(x, y), np.zeros((y.size, x.size))], axis=-1)
    local = grid.reshape(-1, 3)
    local[:, 2] = caster.origin @ axes[2] + 3 * caster.radius
    distance, face = caster.hits(local @ axes, -axes[2])
    hit = face >= 0
    smooth = topology.vertex_normals(caster.vertices, caster.faces)
    where = local[hit] @ axes - distance[hit, None] * axes[2]
    weights = caster.weights(where, face[hit])
    normals = np.einsum("ij,ijk->ik", weights, smooth[caster.faces[face[hit]]])
    light = np.array([-0.35, 0.45, 0.82]) @ axes
    inside = caster.normals[face[hit]] @ axes[2] < 0
    cosine = np.clip(normals @ light, 0, 1)
    picture = np.ones((len(local), 3))
    picture[hit] = _SKIN * (0.25 + 0.75 * cosine)[:, None]
    picture[np.flatnonzero(hit)[inside]] *= (0.75, 0.8, 1.0)  # a back face: bluish
    return picture.reshape(y.size, x.size, 3)


def _in_sight(
    points: Points, edges: NDArray[np.int64], caster: Caster, axes: Array
) -> Array:
    """Return the lines (k, 2, 2) of the edges that nothing stands before."""
    if len(edges) == 0:
        return np.zeros((0, 2, 2))
    middle = points[edges].mean(axis=1) + _LIFT * axes[2]
    before, _ = caster.hits(middle, axes[2])
    return np.asarray(points[edges[np.isinf(before)]] @ axes[:2].T)


def _legend(figure: Figure) -> None:
    """Name the colours of the marks."""
    from matplotlib.lines import Line2D

    named = (
        ("outline of a hole (of views: where no other covers it)", _HOLE),
        ("opening at the wrist", _WRIST),
        ("non-manifold edge", _BAD),
    )
    handles = [Line2D([], [], color=c, linewidth=2.2, label=n) for n, c in named]
    figure.legend(handles=handles, loc="lower center", ncols=3, frameon=False)


def _scale_bar(ax: Axes, low: Array, high: Array) -> None:
    """Draw 50 mm into a panel's lower right corner."""
    right, bottom = high[0] - 2, low[1] + 2
    ax.plot([right - 50, right], [bottom, bottom], color="0.1", linewidth=2)
    ax.text(right - 25, bottom + 3, "50 mm", ha="center", va="bottom", color="0.1")
