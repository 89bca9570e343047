"""``skinviz info``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinviz.cli.arguments import UNCHANGED, WhatIf
from skinviz.cli.output import say, say_json
from skinviz.errors import ArgumentError, DataError

if TYPE_CHECKING:
    from skinviz.rendering.plan import Plan
    from skinviz.scene.relief import Relief
    from skinviz.scene.scene import Scene


_PICTURES = (".png", ".tif", ".tiff", ".exr", ".hdr")


def info(
    file: Path,
    /,
    *,
    unit: str | None = None,
    tolerance: float | None = None,
    what_if: WhatIf = UNCHANGED,
    json: bool = False,
) -> None:
    """Say what a scene, a scan or a picture holds, and how it is or was computed.

    Example: skinviz info scene.toml

    Parameters
    ----------
    file
        Scene file (.toml), raw scan, mesh, or a picture that skinviz wrote.
    unit
        Unit of length in a scan or mesh file, unless it states it.
    tolerance
        Of a scene: also say how its picture is computed so that 99 % of the colours
        differ by no more than this from the reference's, in ΔE00; knob by knob.
    json
        Print it as JSON.
    """
    suffix = file.suffix.lower()
    planned: Plan | None = None
    if (tolerance is not None or what_if != UNCHANGED) and suffix != ".toml":
        raise ArgumentError(
            f"{file}: --tolerance, --melanin and the like are for scenes (.toml); "
            "leave them out"
        )
    if suffix in (".csv", ".json"):
        raise DataError(
            f"{file}: info is for scenes (.toml), scans, meshes and pictures; spectra "
            "are shown by skinviz fit"
        )
    if suffix == ".toml":
        from skinviz.scene.scene_file import read_scene

        scene = what_if.of(read_scene(file))
        facts = _scene_facts(scene)
        if tolerance is not None:
            from skinviz.rendering.planner import plan

            planned = plan(scene, tolerance)
    elif suffix in _PICTURES:
        from skinviz.rendering.files import read_picture_metadata

        facts = read_picture_metadata(file)
        facts = facts if json else _told(facts)
    else:
        from skinviz.cli.scan_facts import scan_facts
        from skinviz.scan.formats import read_scan

        facts = scan_facts(read_scan(file, unit))
    if json:
        say_json(facts | ({"plan": asdict(planned)} if planned else {}))
        return
    _say_facts(facts)
    if planned is not None:
        say(f"\n{planned.explain()}")


def _say_facts(facts: dict[str, Any]) -> None:
    """Say facts, a line each."""
    width = max(len(name) for name in facts)
    for name, value in facts.items():
        for i, line in enumerate(value if isinstance(value, list) else [value]):
            say(f"{name if i == 0 else '':<{width}}  {line}")


def _told(metadata: dict[str, Any]) -> dict[str, Any]:
    """Return a picture's metadata a line each, what is nested within it as JSON."""
    from json import dumps

    flat = dict(metadata)
    for key in ("scene", "units"):
        flat |= flat.pop(key, {})
    return {
        key: value if isinstance(value, str) else dumps(value, ensure_ascii=False)
        for key, value in flat.items()
    }


def _scene_facts(scene: Scene) -> dict[str, Any]:
    """Return what a scene holds, what is computed and what is left out."""
    import numpy as np

    model, surface = scene.skin.model, scene.surface
    weights = np.atleast_2d(scene.skin.values)
    names = [p.name for p in model.parameters]
    body = model.diffuse(scene.skin.values, scene.wavelengths)
    given = "at each vertex" if scene.skin.values.ndim == 2 else "uniform"
    return {
        "mesh": f"{scene.mesh.n_points} vertices, {scene.mesh.n_cells} triangles",
        "skin": [
            f"{model.name}, {given}; specular {model.specular}",
            ", ".join(
                f"{name} {low:.4g}" + (f" to {high:.4g}" if high > low else "")
                for name, low, high in zip(
                    names, weights.min(axis=0), weights.max(axis=0), strict=True
                )
            ),
            *scene.skin.history,
            *_relief(scene.relief),
        ],
        "surface": surface.description,
        "lights": [
            f"{light.spectrum.name}, strength {light.strength:g}, {light.place}"
            for light in scene.lights
        ],
        "view": [_view(scene), _frame(scene)],
        "computed": _computed(scene),
        "left out": _left_out(scene),
        "energy": _energy(float(np.max(body)), scene),
    }


def _relief(relief: Relief) -> list[str]:
    """Return what is said of fine relief, if there is any."""
    if relief.depth == 0:
        return []
    return [
        f"furrows {relief.depth:g} µm deep, {relief.spacing:g} mm apart, seed "
        f"{relief.seed}: they tilt normals, not the mesh"
    ]


def _view(scene: Scene) -> str:
    """Return from where a scene is seen."""
    import numpy as np

    camera = scene.camera
    width, height = camera.size
    far = np.isinf(camera.distance)
    rays = "parallel rays" if far else f"the eye {camera.distance:g} mm from its target"
    return (
        f"from {np.round(camera.direction, 3).tolist()}, {rays}, {width} x {height} "
        "pixels"
    )


def _frame(scene: Scene) -> str:
    """Return what part of a scene is seen, and for which display."""
    import numpy as np

    camera = scene.camera
    shown = "the whole mesh" if camera.height is None else f"{camera.height:g} mm high"
    if camera.target is not None:
        shown += f" about {np.round(camera.target, 3).tolist()} mm"
    adapted = "no adaptation" if scene.white == "none" else f"{scene.white} adaptation"
    return f"{shown}; for {scene.display.name}, {adapted}, exposure {scene.exposure:g}"


def _computed(scene: Scene) -> list[str]:
    """Return what is computed of a scene."""
    bands = scene.wavelengths
    bounce = scene.interreflection != "none"
    return [
        f"radiance of every pixel on {bands.size} wavelengths, {bands[0]:g}-"
        f"{bands[-1]:g} nm: diffuse (Lambert) and specular, with cast shadows"
        + (" and one diffuse bounce of light" if bounce else ""),
        f"colour through CIE XYZ ({scene.observer})",
    ]


def _left_out(scene: Scene) -> str:
    """Return what is not computed of a scene."""
    bounce = (
        "light that bounces more than once"
        if scene.interreflection != "none"
        else 'light between fingers (interreflection = "none")'
    )
    return f"{bounce}; transport of light along the skin"


def _energy(body: float, scene: Scene) -> str:
    """Return the most that the scene's surface can reflect, with a warning above 1."""
    from skinviz.rendering.lighting import fresnel_basis
    from skinviz.rendering.shade import vertex_gloss
    from skinviz.surface.energy import specular_albedo

    surface = scene.surface
    n = fresnel_basis(scene, scene.wavelengths, "dispersion")[0].max()
    gloss = specular_albedo(surface, n=n)
    most = scene.diffuse_scale * body + gloss
    warning = "" if most <= 1 else "; above 1: the surface gives off more than it gets"
    brightest = float(vertex_gloss(scene).max())
    if getattr(surface, "masking", "") == "none" and brightest > 1:
        warning += (
            f"; eq. (10) without masking diverges here, up to {brightest:.3g} times "
            "white: choose masking v-cavity"
        )
    return (
        f"at most {most:.3f} of the light: diffuse {scene.diffuse_scale * body:.3f} + "
        f"specular {gloss:.3f} (up to 80 degrees){warning}"
    )
