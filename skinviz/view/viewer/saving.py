"""What a state leaves behind: a scene file, a figure, and the command for both."""

from __future__ import annotations

import copy
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from skinviz._files import whole_file
from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.rendering.render import render
from skinviz.scene.scene import Scene
from skinviz.view.figures import MarkedPoint, Site, hands_figure, save_figure
from skinviz.view.viewer.opened import WIDTHS, Opened, as_shown, has
from skinviz.view.viewer.pictures import Shown
from skinviz.view.viewer.readings import readings_of
from skinviz.view.viewer.samples import weights_table
from skinviz.view.viewer.shown import index_value, scenes_of
from skinviz.view.viewer.state import ViewState

SCENE_SUFFIXES = (".toml",)
FIGURE_SUFFIXES = (".png", ".svg", ".pdf")

_PLAIN_NAME = re.compile(r"[\w][\w. -]{0,99}", re.UNICODE)
_LONGEST = 200  # bytes of a name, as most disks have 255 and files begin hidden
_FIGURE_SIZE = (675, 900)  # pixels, of each hand


def file_named(opened: Opened, name: str, suffixes: tuple[str, ...]) -> Path:
    """Return the path of a file in the opened folder, and in no other.

    Raises
    ------
    ArgumentError
        If the name is no plain one, its suffix is another, or a file or link that
        the viewer did not write stands there.
    """
    plain = isinstance(name, str) and _PLAIN_NAME.fullmatch(name) and ".." not in name
    if not plain or len(name.encode()) > _LONGEST:
        raise ArgumentError(
            f"{str(name)[:60]!r} is no name of a file; use up to 100 letters, "
            "digits, '-', '_' and '.', without a folder"
        )
    file = opened.folder / name
    one_of(file.suffix.lower(), suffixes, "suffix of the file")
    if file.is_symlink() or file.exists():
        raise ArgumentError(f"{name} is there already; choose another name")
    return file


def save_scene(opened: Opened, shown: Shown, name: str) -> Path:
    """Write what is shown of the active hand as a scene file.

    Raises
    ------
    SkinvizError
        If the name is not allowed, or there is no file to which it is a change.
    """
    file = file_named(opened, name, SCENE_SUFFIXES)
    text = toml_text(scene_content(opened, shown))
    with whole_file(file) as partial:
        partial.write_text(text, encoding="utf-8")
    return file


def command(name: str, state: ViewState) -> str:
    """Return the command that draws a saved scene's picture anew."""
    picture = Path(name).with_suffix(".png").name
    return (
        f"skinviz render {shlex.quote(name)} -o {shlex.quote(picture)} "
        f"--tolerance {state.tolerance:g}"
    )


def save_view_figure(opened: Opened, shown: Shown, name: str) -> Path:
    """Write the figure of what is shown, as PNG, SVG or PDF.

    Raises
    ------
    SkinvizError
        If the name is not allowed or it cannot be written.
    """
    file = file_named(opened, name, FIGURE_SUFFIXES)
    state = shown.state
    scenes = scenes_of(opened, state, shown.samples, _FIGURE_SIZE)
    titles = [_title(shown, i) for i in range(len(scenes))]
    pictures = {
        title: render(scene, None, state.tolerance, geometry=opened.geometry)
        for title, scene in zip(titles, scenes, strict=True)
    }
    marks = [
        MarkedPoint(np.array(one.mark.place), one.spectrum, titles[one.mark.look])
        for one in readings_of(shown)
        if one is not None
    ]
    sample = shown.samples[state.active]
    fit = None if state.look.weights else sample.fit
    site = None
    if fit is not None and sample.measured is not None:
        site = Site(sample.name, sample.measured, fit)
    figure = hands_figure(
        pictures,
        site,
        marks,
        f"{opened.name}.  {shown.stages[0].scene.surface.description}.  "
        f"ΔE00 tolerance {state.tolerance:g}.",
    )
    return save_figure(figure, file)


def scene_content(opened: Opened, shown: Shown) -> dict[str, Any]:
    """Return the active hand's scene as a scene file's content."""
    if opened.content is None:
        raise ArgumentError(
            "this scene was made in Python, so there is no scene file to save a change "
            "of; open a scene file with: skinviz view scene.toml"
        )
    state = shown.state
    stage = shown.stages[state.active]
    content = copy.deepcopy(opened.content)
    initial, scene = opened.initial, stage.scene
    if state.look != initial.looks[0]:
        content["skin"] = _skin_table(shown) | _relief_table(scene)
    if any(getattr(state, n) != getattr(initial, n) for n in _OF_SURFACE):
        content["surface"] = _surface_table(state, scene)
    content["lights"] = _lights_tables(content.get("lights", [{}]), state, scene)
    view = content.setdefault("view", {})
    view.pop("angles", None)
    view["direction"] = scene.camera.direction.tolist()
    view["up"] = scene.camera.up.tolist()
    view["size"] = list(scene.camera.size)
    if scene.camera.target is not None:
        view["target"] = np.round(scene.camera.target, 6).tolist()
    if scene.camera.height is not None:
        view["height"] = float(scene.camera.height)
    if state.exposure != initial.exposure:
        view["exposure"] = state.exposure
    if state.white != initial.white:
        content.setdefault("display", {})["white"] = state.white
    return content


_OF_SURFACE = ("surface", "width", "index", "specular_scale")


def toml_text(content: dict[str, Any]) -> str:
    """Return a scene file's content as TOML."""
    blocks = []
    for name, table in content.items():
        for one in table if isinstance(table, list) else [table]:
            head = f"[[{name}]]" if isinstance(table, list) else f"[{name}]"
            blocks.append(
                "\n".join([head, *(f"{k} = {_toml(v)}" for k, v in one.items())])
            )
    return "\n\n".join(blocks) + "\n"


def _toml(value: Any) -> str:
    """Return one value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return repr(value)


def _skin_table(shown: Shown) -> dict[str, Any]:
    """Return [skin] of the active hand: whose it is, or its weights."""
    sample, look = shown.samples[shown.state.active], shown.state.look
    if not look.weights:
        return dict(sample.table)
    if sample.skin.values.ndim == 2:
        raise ArgumentError(
            "a scene file cannot say scaled maps of pigments; undo the change of the "
            "weights"
        )
    table = weights_table(as_shown(sample, look.weights))
    # By the name that the file has for them, which may be a path.
    named = ("coefficients", "free")
    return table | {key: sample.table[key] for key in named if key in sample.table}


def _relief_table(scene: Scene) -> dict[str, Any]:
    """Return what [skin] says of fine relief: it is of the mesh, and stays."""
    relief = scene.relief
    if not relief.depth:
        return {}
    own = {"relief_um": relief.depth, "relief_mm": relief.spacing, "seed": relief.seed}
    return {"texture": own}


def _surface_table(state: ViewState, scene: Scene) -> dict[str, Any]:
    """Return [surface] as the controls set it."""
    table: dict[str, Any] = {"model": state.surface}
    said = {
        WIDTHS.get(state.surface, ""): state.width,
        "n": index_value(state.index),
        "specular_scale": state.specular_scale,
        "masking": getattr(scene.surface, "masking", "v-cavity"),
    }
    return {**table, **{k: v for k, v in said.items() if has(state.surface, k)}}


def _lights_tables(
    given: list[dict[str, Any]], state: ViewState, scene: Scene
) -> list[dict[str, Any]]:
    """Return [[lights]], each with its place said outright and its lamp as it was."""
    tables = []
    for i, (table, light) in enumerate(zip(given, scene.lights, strict=True)):
        own = {k: v for k, v in table.items() if k not in _PLACES}
        *at, near = light.homogeneous.tolist()
        own["position" if near else "direction"] = at
        if i == 0 and state.illuminant:
            own = {k: v for k, v in own.items() if k not in _LAMPS}
            own["illuminant"] = state.illuminant
        tables.append(own)
    return tables


_PLACES = ("angle", "direction", "position")
_LAMPS = ("illuminant", "temperature", "spectrum", "lines")


def _title(shown: Shown, i: int) -> str:
    """Return what stands above a hand."""
    lamp = shown.stages[i].scene.lights[0].spectrum.name
    sample, weights = shown.samples[i], shown.state.looks[i].weights
    names = [parameter.name for parameter in sample.skin.model.parameters]
    set_to = [f"{n} {w:.4g}" for n, w in zip(names, weights, strict=False)]
    name = ", ".join([sample.name, *set_to, lamp])
    return name if len(shown.stages) == 1 else f"{i + 1}: {name}"
