"""Pictures of a state: quick ones while something moves, and the planned one after."""

from __future__ import annotations

import io
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import SceneWarning
from skinviz.rendering.held import ONE_RAY, HeldView, hold
from skinviz.rendering.imager import Advance
from skinviz.rendering.plan import Plan
from skinviz.rendering.render import Rendering, render
from skinviz.rendering.spectral import white_xyz
from skinviz.rendering.stage import Stage
from skinviz.rendering.tolerance import colour_differences
from skinviz.scene.scene import Scene
from skinviz.view.viewer.opened import Opened
from skinviz.view.viewer.samples import Sample
from skinviz.view.viewer.shown import Size, sample_of, scenes_of
from skinviz.view.viewer.state import Look, ViewState
from skinviz.view.viewer.tiles import Tiles, tiles_of

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Made = TypeVar("Made")

_VIEWS = 2  # that are kept, of some tens of megabytes each
_SAMPLES = 8
_MAPPED = ONE_RAY.replace(spectrum="10 nodes", reflectance="vertices")
_GAP = 24


@dataclass(frozen=True, eq=False)
class Shown:
    """A state's quick picture and what it was made of.

    Attributes
    ----------
    state : ViewState
        What is shown.
    samples : tuple of Sample
        Whose skin each hand has.
    stages : tuple of Stage
        Each hand's scene, as it is seen.
    held : HeldView
        What the pixels of each tile see.
    tiles : Tiles
        Where the hands are in the picture.
    picture : (height, width, 3) ndarray of uint8
        What the display shows.
    scale : float
        ΔE00 at the end of the difference map's colours; 0 without such a map.
    """

    state: ViewState
    samples: tuple[Sample, ...]
    stages: tuple[Stage, ...]
    held: HeldView
    tiles: Tiles
    picture: Picture
    scale: float


@dataclass(frozen=True, eq=False)
class Still:
    """A state's picture within its tolerance.

    Attributes
    ----------
    picture : (height, width, 3) ndarray of uint8
        What the display shows.
    plan : Plan
        How the first hand was computed.
    seconds : float
        What it took, all hands together.
    notes : tuple of str
        What is to be known of the picture.
    """

    picture: Picture
    plan: Plan
    seconds: float
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Darkroom:
    """Where pictures are made; it keeps the last views and fits, nothing else.

    Attributes
    ----------
    opened : Opened
        What there is to show.
    """

    opened: Opened
    _views: dict[Any, HeldView] = field(default_factory=dict)
    _samples: dict[Any, Sample] = field(default_factory=dict)

    def quick(self, state: ViewState, size: Size) -> Shown:
        """Return the picture with one ray a pixel, exact but for edges."""
        tiles = tiles_of(len(state.looks) + state.difference, size)
        samples = tuple(self._sample(look) for look in state.looks)
        scenes = scenes_of(self.opened, state, samples, tiles.size)
        held = self._view(scenes[0], state)
        stages = tuple(held.stage(scene, _quick_plan(scene)) for scene in scenes)
        parts = [held.rgb(stage) for stage in stages]
        scale = 0.0
        if state.difference:
            light = [np.concatenate(held.xyz(stage)) for stage in stages]
            part = _ground(scenes[0], tiles.size)
            scale = _draw_differences(
                part, np.concatenate(held.pixels), light, stages[0].white
            )
            parts.append(part)
        picture = tiles.joined(parts, _GAP)
        return Shown(state, samples, stages, held, tiles, picture, scale)

    def still(
        self, state: ViewState, size: Size, advance: Advance | None = None
    ) -> Still:
        """Return the picture that keeps the state's tolerance.

        ``advance`` is told the number of pixels done, as they are; what it raises ends
        the work.
        """
        started = time.perf_counter()
        tiles = tiles_of(len(state.looks) + state.difference, size)
        samples = tuple(self._sample(look) for look in state.looks)
        scenes = scenes_of(self.opened, state, samples, tiles.size)
        drawn = [self._drawn(scene, state.tolerance, advance) for scene in scenes]
        parts = [one.rgb for one in drawn]
        if state.difference:
            part = _ground(scenes[0], tiles.size)
            pixels = np.flatnonzero(drawn[0].covered)
            light = [one.xyz.reshape(-1, 3)[pixels] for one in drawn]
            _draw_differences(part, pixels, light, white_xyz(scenes[0]))
            parts.append(part)
        return Still(
            tiles.joined(parts, _GAP),
            drawn[0].plan,
            time.perf_counter() - started,
            tuple(dict.fromkeys(note for one in drawn for note in one.notes)),
        )

    def _drawn(
        self, scene: Scene, tolerance: float, advance: Advance | None
    ) -> Rendering:
        """Return the rendering of one hand."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # told as notes
            return render(
                scene, None, tolerance, geometry=self.opened.geometry, advance=advance
            )

    def _view(self, scene: Scene, state: ViewState) -> HeldView:
        """Return a view whose rays are cast, the last ones from memory."""
        key = (scene.camera.size, state.view, state.zoom, state.shift)
        cast = partial(hold, self.opened.geometry, scene.camera, scene.relief)
        return _kept(self._views, key, cast, _VIEWS)

    def _sample(self, look: Look) -> Sample:
        """Return whose skin a hand has, the last ones from memory."""
        key = (look.person, look.site)
        fitted = partial(sample_of, self.opened, look)
        return _kept(self._samples, key, fitted, _SAMPLES)


def _kept(kept: dict[Any, Made], key: Any, make: Callable[[], Made], n: int) -> Made:
    """Return what was made for a key before, or make it; only the last n are kept."""
    found = kept.pop(key, None)
    kept[key] = made = make() if found is None else found
    while len(kept) > n:
        kept.pop(next(iter(kept)))
    return made


def _quick_plan(scene: Scene) -> Plan:
    """Return how a quick picture is computed: exact where all points share spectra."""
    return ONE_RAY if scene.skin.values.ndim == 1 else _MAPPED


def _ground(scene: Scene, size: Size) -> Picture:
    """Return a picture of nothing."""
    picture = np.zeros((size[1], size[0], 3), np.uint8)
    picture[:] = scene.background
    return picture


def _draw_differences(
    picture: Picture,
    pixels: NDArray[np.int64],
    light: Sequence[NDArray[np.floating]],
    white: Array,
) -> float:
    """Draw ΔE00 of pixels (n,) as colours; return what the last colour stands for.

    ``light`` has two pictures' XYZ (n, 3).
    """
    one, other = (np.asarray(own, np.float64) for own in light)
    differences = colour_differences(one, other, white)
    most = float(np.percentile(differences, 99)) if differences.size else 0.0
    scale = nice_above(most)
    levels = (np.clip(differences / scale, 0, 1) * 255).astype(int)
    picture.reshape(-1, 3)[pixels] = difference_colours()[levels]
    return scale


def difference_colours() -> Picture:
    """Return the colours (256, 3) of differences from 0 to the scale's end."""
    from matplotlib import colormaps

    return np.asarray(np.rint(255 * colormaps["viridis"](np.arange(256))[:, :3]), "u1")


def nice_above(value: float) -> float:
    """Return 1, 2 or 5 times a power of ten that is not below a value."""
    if value <= 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(n * power for n in (1, 2, 5, 10) if n * power >= value * 0.9999))


def jpeg(picture: Picture) -> bytes:
    """Return a picture as a small file, for what moves."""
    return _encoded(picture, "JPEG", quality=88)


def png(picture: Picture) -> bytes:
    """Return a picture as a file that holds every level, for what is still."""
    return _encoded(picture, "PNG", compress_level=1)


def _encoded(picture: Picture, kind: str, **options: Any) -> bytes:
    """Return a picture's file."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(picture).save(file, kind, **options)
    return file.getvalue()
