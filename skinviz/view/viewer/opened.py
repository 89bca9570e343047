"""What is opened once and stays: the mesh, its file, the people to choose from."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import MeshError, SkinvizError
from skinviz.rendering.geometry import Geometry, geometry_of
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scene.hand import HandFrame, hand_frame
from skinviz.scene.scene import Scene, Skin
from skinviz.scene.scene_file import named, read_scene_content, scene_from
from skinviz.spectra.archives import load_archive
from skinviz.study.study_file import read_study
from skinviz.surface.models import surface_parameters
from skinviz.surface.surface import Surface
from skinviz.view.viewer.samples import (
    ANY_GROUP,
    ArchiveSamples,
    Sample,
    Samples,
    StudySamples,
)
from skinviz.view.viewer.state import ViewState
from skinviz.view.viewer.turning import angles_of, view_of

Array = NDArray[np.float64]

WIDTHS = {
    "torrance-sparrow": "gamma",
    "cook-torrance": "roughness",
    "phong": "exponent",
}
"""What says how wide each surface's lobe is."""

_ARCHIVE = "issa"  # whose people are offered where a scene names none
_DEMO = {
    "skin": {
        "archive": _ARCHIVE,
        "origin": "China",
        "subject": "186",
        "site": "back of hand",
    }
}


@dataclass(frozen=True, eq=False)
class Opened:
    """What the viewer was opened with.

    Attributes
    ----------
    name : str
        For people to read.
    scene : Scene
        As it was given.
    own : Sample
        The scene's own skin.
    samples : Samples
        The people to choose from.
    folder : Path
        Where files are written, and nowhere else.
    content : dict or None
        What the scene's file says; None where there is no file.
    """

    name: str
    scene: Scene
    own: Sample
    samples: Samples
    folder: Path
    content: dict[str, Any] | None

    @cached_property
    def geometry(self) -> Geometry:
        """The scene's mesh, made ready."""
        return geometry_of(self.scene.mesh)

    @cached_property
    def frame(self) -> HandFrame:
        """From which angles count: the hand's, or the camera's where it is no hand."""
        return _frame(self.scene)

    @cached_property
    def initial(self) -> ViewState:
        """What is shown first: the scene as it is."""
        return initial_state(self.scene, self.geometry, self.frame)


def open_path(path: Path | None) -> Opened:
    """Open a scene file, the folder of a study, or the shipped hand.

    Raises
    ------
    SkinvizError
        As :func:`skinviz.read_scene` or :func:`skinviz.read_study`.
    """
    if path is None:
        return _from_content("shipped hand", {"mesh": _shipped(), **_DEMO}, Path.cwd())
    if path.is_dir():
        return _open_study(path)
    content = read_scene_content(path)
    try:
        return _from_content(path.name, content, path.parent.resolve())
    except SkinvizError as error:
        raise named(error, path) from error


def _open_study(folder: Path) -> Opened:
    """Open a study: the shipped hand, in the skin of its first subject."""
    samples = StudySamples(read_study(folder))
    person = samples.people(ANY_GROUP)[0]
    own = samples.sample(person, samples.sites(person)[0])
    content = {"mesh": _shipped(), "skin": own.table}
    scene = scene_from(content, folder, own.skin)
    title = samples.study.title
    return Opened(title, scene, own, samples, folder.resolve(), content)


def _shipped() -> dict[str, Any]:
    """Return what a scene file says of the shipped hand."""
    return {"path": str(shipped_mesh(TRUE_SHAPE)), "unit": "m"}


def open_scene(scene: Scene) -> Opened:
    """Open a scene that was made in Python."""
    own = Sample("the scene's own skin", scene.skin, None, None, None, {})
    samples = ArchiveSamples(_ARCHIVE, load_archive(_ARCHIVE), {})
    return Opened("scene", scene, own, samples, Path.cwd(), None)


def _from_content(name: str, content: dict[str, Any], folder: Path) -> Opened:
    """Open what a scene file says."""
    table = content.get("skin", {})
    archive = table.get("archive", _ARCHIVE)
    options = {key: table[key] for key in _OPTIONS if key in table}
    if "archive" not in table:
        options = {}
    samples = ArchiveSamples(archive, load_archive(archive), options)
    fitted = _fitted(table, samples)
    scene = scene_from(content, folder, None if fitted is None else fitted.skin)
    own = _own(scene.skin, table, folder, fitted)
    return Opened(name, scene, own, samples, folder, content)


_OPTIONS = ("model", "specular", "thickness", "coefficients", "free")


def _fitted(table: dict[str, Any], samples: ArchiveSamples) -> Sample | None:
    """Return the archive's person that [skin] names, None where it names none."""
    if not {"archive", "origin", "subject", "site"} <= table.keys():
        return None
    person = f"{table['origin']}/{table['subject']}"
    return samples.sample(person, str(table["site"]))


def _own(
    skin: Skin, table: dict[str, Any], folder: Path, fitted: Sample | None
) -> Sample:
    """Return a scene's skin with what is known of it."""
    if fitted is None:
        interval = _interval(folder / table["fit"], table) if "fit" in table else None
        own = Sample("the scene's own skin", skin, None, None, interval, table)
    else:
        own = dataclasses.replace(fitted, skin=skin, table=table)
    if skin.history:  # mapped or changed: no longer the skin that was fitted
        return dataclasses.replace(own, interval=None)
    return own


def _interval(file: Path, table: dict[str, Any]) -> Array | None:
    """Return the intervals (p, 2) that a fit file holds, None where one is missing."""
    fits = json.loads(file.read_text(encoding="utf-8"))["fits"]
    record = table.get("record", 0)
    if isinstance(record, str):
        record = [fit["label"] for fit in fits].index(record)
    own = fits[record]["parameters"].values()
    pairs = [(one.get("lower"), one.get("upper")) for one in own]
    if any(value is None for pair in pairs for value in pair):
        return None
    return np.array(pairs, dtype=np.float64)


def initial_state(scene: Scene, geometry: Geometry, frame: HandFrame) -> ViewState:
    """Return the state that shows a scene as it is."""
    surface, light = scene.surface, scene.lights[0].homogeneous
    to_light = light[:3] - light[3] * centroid(geometry)
    return ViewState(
        light=angles_of(frame, to_light / np.linalg.norm(to_light)),
        view=view_of(frame, scene.camera.direction, scene.camera.up),
        surface=type(surface).name,
        width=width_of(surface),
        index=index_of(surface),
        specular_scale=float(getattr(surface, "specular_scale", 1.0)),
        exposure=scene.exposure,
        white=scene.white,
    )


def centroid(geometry: Geometry) -> Array:
    """Return the mean of the surface (3,). [mm]"""
    return np.asarray(geometry.centre + geometry.scale * geometry.centroid)


def width_of(surface: Surface) -> float:
    """Return how wide a surface's lobe is, in its own measure."""
    return float(getattr(surface, WIDTHS.get(type(surface).name, ""), 0.0))


def index_of(surface: Surface) -> str:
    """Return a surface's refractive index, or the name of its dispersion."""
    n = surface.n
    return f"{n:g}" if isinstance(n, float | int) else n.name


def has(surface: str, parameter: str) -> bool:
    """Return whether a surface model has a parameter."""
    return parameter in surface_parameters(surface)


def _frame(scene: Scene) -> HandFrame:
    """Return the hand's directions, or the camera's where it is no hand."""
    try:
        return hand_frame(scene.mesh)
    except MeshError:
        back, up = scene.camera.direction, scene.camera.up
        return HandFrame(back, up, np.cross(up, back))


def as_shown(sample: Sample, weights: tuple[float, ...]) -> Skin:
    """Return skin with other weights: maps are scaled to have them as their means."""
    skin = sample.skin
    if not weights:
        return skin
    wanted = np.array(weights, dtype=np.float64)
    if skin.values.ndim == 1:
        return dataclasses.replace(skin, values=wanted)
    mean = skin.values.mean(axis=0)
    # A pigment that is nowhere is laid on evenly.
    scaled = skin.values * (wanted / np.where(mean == 0, 1.0, mean))
    return dataclasses.replace(skin, values=np.where(mean == 0, wanted, scaled))
