"""``skinviz render``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import progress_bar, say, say_files, say_json

if TYPE_CHECKING:
    from skinviz.rendering.render import Rendering
    from skinviz.scene.scene import Scene


def render(
    scene: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    spectral: Path | None = None,
    mesh: Path | None = None,
    size: Whole | None = None,
    samples: Whole = 16,
    json: bool = False,
) -> None:
    """Draw a scene in spectrally computed colour, traced ray by ray.

    Every pixel's radiance is computed on the scene's wavelengths, 61 by default, and
    shown through CIE XYZ, with cast shadows.

    Example: skinviz render scene.toml -o hand.png --spectral hand.hdr --size 2048

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
    samples
        Rays a pixel: 1, 2, 4, 8 or 16. Fewer is faster and rougher at edges.
    json
        Print the files and what the display could not show as JSON.
    """
    import warnings

    from skinviz.errors import SceneWarning
    from skinviz.rendering.geometry import geometry_of
    from skinviz.rendering.plan import Plan
    from skinviz.rendering.render import render as rendered
    from skinviz.rendering.shade import shade
    from skinviz.scan.formats import write_mesh
    from skinviz.scene.scene_file import read_scene

    _require_suffixes(out, spectral, mesh)
    plan = Plan(samples=samples)
    with progress_bar(3 + (spectral is not None) + (mesh is not None)) as begin:
        begin("read scene")
        described = _sized(read_scene(scene), size)
        width, height = described.camera.size
        begin("trace rays")
        geometry = geometry_of(described.mesh)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # said below, as notes
            picture = rendered(
                described,
                plan,
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
            files.append(write_mesh(mesh, shade(described, plan, geometry=geometry)))
    told = _told(picture)
    if json:
        say_json({"files": [str(f) for f in files], **told})
        return
    say_files(files)
    for note in told["notes"]:
        say(f"note: {note}")


def _require_suffixes(out: Path, spectral: Path | None, mesh: Path | None) -> None:
    """Refuse files of other kinds before anything is computed."""
    from skinviz._validate import one_of

    one_of(out.suffix.lower(), (".png", ".tif", ".tiff"), "suffix of --out")
    if spectral is not None:
        one_of(spectral.suffix.lower(), (".hdr", ".exr"), "suffix of --spectral")
    if mesh is not None:
        one_of(mesh.suffix.lower(), (".vtp",), "suffix of --mesh")


def _sized(scene: Scene, size: int | None) -> Scene:
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
