"""``skinviz render``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import UNCHANGED, WhatIf, Whole
from skinviz.cli.output import progress_bar, say, say_files, say_json

if TYPE_CHECKING:
    from skinviz.rendering.plan import Plan
    from skinviz.rendering.render import Rendering
    from skinviz.scene.scene import Scene

_USUAL = 1.0  # ΔE00


def render(
    scene: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    spectral: Path | None = None,
    mesh: Path | None = None,
    size: Whole | None = None,
    tolerance: float | None = None,
    samples: Whole | None = None,
    explain: bool = False,
    what_if: WhatIf = UNCHANGED,
    json: bool = False,
) -> None:
    """Draw a scene in spectrally computed colour, traced ray by ray.

    Every pixel's radiance is computed on the scene's wavelengths, 61 by default, and
    shown through CIE XYZ. What would change colours by less than the tolerance is
    left out. What the skin has more or less of is said by x2 (times two), +0.01 (more
    by that) or 0.4 (so much).

    Example: skinviz render scene.toml -o hand.png --spectral hand.hdr --size 2048
    Example: skinviz render scene.toml -o tanned.png --melanin x2

    Parameters
    ----------
    scene
        Scene file (TOML).
    out
        Picture to write, .png (8 bits) or .tif (16 bits).
    spectral
        Spectrum of every pixel to write, .hdr (ENVI) or .exr.
    mesh
        Mesh to write with pigments, radiance and colour at every vertex, .vtp.
    size
        Longer side of the picture in pixels, instead of the scene's size.
    tolerance
        What 99 % of the colours may differ by from the reference's, in ΔE00; 1 if
        neither this nor samples is given.
    samples
        Rays a pixel instead of a tolerance, 1, 2, 4, 8 or 16, all else exact; 16 is
        the reference.
    explain
        Print what the tolerance left out, what that changes and what it saves.
    json
        Print the files, the plan and what the display could not show as JSON.
    """
    import dataclasses
    import warnings

    from skinviz.errors import SceneWarning
    from skinviz.rendering.geometry import geometry_of
    from skinviz.rendering.render import render as rendered
    from skinviz.rendering.shade import shade
    from skinviz.scan.formats import write_mesh
    from skinviz.scene.scene_file import read_scene

    _require_suffixes(out, spectral, mesh)
    plan, allowed = _asked(tolerance, samples)
    with progress_bar(3 + (spectral is not None) + (mesh is not None)) as begin:
        begin("read scene")
        described = what_if.of(sized(read_scene(scene), size))
        width, height = described.camera.size
        begin("trace rays" if plan else "plan and trace rays")
        geometry = geometry_of(described.mesh)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # said below, as notes
            picture = rendered(
                described,
                plan,
                allowed,
                geometry=geometry,
                advance=begin.counting(width * height),
            )
        begin("write picture")
        files = [picture.save(out)]
        if spectral is not None:
            begin("write spectra")
            counting = begin.counting(width * height)
            files.append(picture.save(spectral, advance=counting))
        if mesh is not None:
            begin("shade and write mesh")
            files.append(write_mesh(mesh, shade(described, geometry=geometry)))
    told = _told(picture)
    if json:
        made = {"plan": dataclasses.asdict(picture.plan)}
        say_json({"files": [str(f) for f in files], **made, **told})
        return
    if explain:
        say(picture.plan.explain())
    say_files(files)
    for note in told["notes"]:
        say(f"note: {note}")


def _asked(tolerance: float | None, samples: int | None) -> tuple[Plan | None, float]:
    """Return the plan, None if it is to be made, and the tolerance it is made for."""
    from skinviz._validate import in_range
    from skinviz.errors import ArgumentError
    from skinviz.rendering.plan import Plan
    from skinviz.rendering.planner import LOOSEST, TIGHTEST

    if samples is None:
        allowed = _USUAL if tolerance is None else tolerance
        return None, in_range(allowed, TIGHTEST, LOOSEST, "--tolerance", "ΔE00")
    if tolerance is not None:
        raise ArgumentError(
            "--tolerance and --samples were both given; give --tolerance to have rays "
            "chosen by what they change, or --samples for as many in every pixel"
        )
    return Plan(samples=samples), _USUAL


def _require_suffixes(out: Path, spectral: Path | None, mesh: Path | None) -> None:
    """Refuse files of other kinds before anything is computed."""
    from skinviz._validate import one_of

    one_of(out.suffix.lower(), (".png", ".tif", ".tiff"), "suffix of --out")
    if spectral is not None:
        one_of(spectral.suffix.lower(), (".hdr", ".exr"), "suffix of --spectral")
    if mesh is not None:
        one_of(mesh.suffix.lower(), (".vtp",), "suffix of --mesh")


def sized(scene: Scene, size: int | None) -> Scene:
    """Return the scene with its picture's longer side of ``size`` pixels."""
    import dataclasses

    import numpy as np

    from skinviz._validate import in_range
    from skinviz.scene.camera import LARGEST_PICTURE

    if size is None:
        return scene
    in_range(size, 1, LARGEST_PICTURE, "--size", "pixels")
    old = scene.camera.size
    width, height = np.maximum(1, np.round(np.multiply(old, size / max(old))))
    camera = dataclasses.replace(scene.camera, size=(int(width), int(height)))
    return scene.replace(camera=camera)


def _told(picture: Rendering) -> dict[str, Any]:
    """Return what the picture's maker should know, as data and in words."""
    counts = picture.counts
    seen = int((picture.covered > 0).sum())
    notes = list(picture.notes)
    for name in ("over_exposed", "out_of_gamut"):
        n = getattr(counts, name)
        if n:
            notes.append(
                f"{n} pixels, {100 * n / seen:.2g} % of the mesh's, are "
                f"{name.replace('_', '-')} on {picture.scene.display.name}"
            )
    return {
        "pixels": {
            "mesh": seen,
            "over_exposed": counts.over_exposed,
            "out_of_gamut": counts.out_of_gamut,
        },
        "notes": notes,
    }
