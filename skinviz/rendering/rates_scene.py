"""The small pieces of work by whose time a machine's rates are told."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from skinviz._threads import processors
from skinviz.rendering import bounce, trace
from skinviz.rendering.lighting import body_at
from skinviz.rendering.plan import MOST_SAMPLES, cells
from skinviz.rendering.stage import Stage, stage_of
from skinviz.rendering.tints import VertexTints, mixing_of, table_of
from skinviz.scan.topology import polydata
from skinviz.scene.camera import Camera
from skinviz.scene.lights import DirectionalLight
from skinviz.scene.scene import Scene, Skin
from skinviz.skin.models import skin_model
from skinviz.surface.torrance_sparrow import TorranceSparrow

Trial = tuple[str, Callable[[], object], float]

_AROUND, _ALONG = 160, 80  # of a ball's vertices: as many as a hand's that are seen


def trials(side: int) -> Iterator[Trial]:
    """Yield the name of each rate, what to run, and how many pieces of work it is."""
    stage = _stage(side)
    geometry, lit = stage.geometry, stage.colours
    _ = geometry.embree
    pixels = np.arange(side * side)
    hits = trace.cast(stage.sight, cells(MOST_SAMPLES), pixels)
    n = hits.rays.size
    seen = (geometry, lit.lighting, hits.lifted, hits.normals, hits.facets)
    scalars = np.zeros((lit.rows, n))
    none = np.zeros((1, n))
    bare = stage.replanned(specular="none").colours.lighting

    def cast() -> object:
        return trace.cast(stage.sight, cells(MOST_SAMPLES), pixels)

    yield "ray", cast, MOST_SAMPLES * pixels.size
    yield "shadow", lambda: trace.visibility(*seen), n
    yield "point", lambda: bare.scalars(hits.points, hits.normals, none), n
    yield "index", lambda: lit.lighting.scalars(hits.points, hits.normals, scalars), n
    values, bands = stage.scene.skin.values, np.arange(400.0, 701.0, 20.0)
    mixing = mixing_of(lit)
    channels = mixing.shape[1]
    body = body_at(stage.scene, values[:2000], lit.spectra.wavelengths)
    table = table_of(stage, mixing, np.float32)
    blended = VertexTints(stage, np.zeros((len(values), channels), np.float32))
    yield "blend", lambda: blended.at(hits), n * channels
    # These share their work among threads themselves.
    own = 1 / processors()
    m, leaving = own * len(values), np.ones((len(values), 1))
    yield "band", lambda: body_at(stage.scene, values, bands), m * bands.size
    yield "mix", lambda: body @ mixing, own * body.size * channels
    yield "look", lambda: table.at(values), m * channels
    yield "bounce", lambda: bounce.gather(geometry, leaving, 16), 16 * m


def _stage(side: int) -> Stage:
    """Return a ball of mapped skin, ready."""
    turn, height = np.meshgrid(
        2 * np.pi * np.arange(_AROUND) / _AROUND,
        np.pi * (np.arange(_ALONG) + 0.5) / _ALONG,
    )
    radius = 40 + 2 * np.sin(5 * turn) * np.sin(3 * height)  # a few folds, for shadows
    points = np.stack(
        [
            radius * np.sin(height) * np.cos(turn),
            radius * np.sin(height) * np.sin(turn),
            radius * np.cos(height),
        ],
        axis=-1,
    ).reshape(-1, 3)
    rng = np.random.default_rng(0)
    values = rng.uniform(0.0, [0.3, 0.02, 0.01], (len(points), 3))
    scene = Scene(
        mesh=polydata(points, _faces()),
        skin=Skin(skin_model(site="back of hand", specular="included"), values),
        surface=TorranceSparrow(),
        lights=(DirectionalLight(np.array([1.0, 0.5, 1.0])),),
        camera=Camera(
            np.array([1.0, 0.0, 0.2]), np.array([0.0, 0.0, 1.0]), (side, side)
        ),
    )
    return stage_of(scene)


def _faces() -> NDArray[np.int64]:
    """Return the triangles of a sleeve, facing outwards."""
    row, column = np.mgrid[: _ALONG - 1, :_AROUND]
    a, b = row * _AROUND + column, row * _AROUND + (column + 1) % _AROUND
    c, d = a + _AROUND, b + _AROUND
    return np.concatenate(
        [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)]
    )
