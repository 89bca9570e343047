"""``skinviz render``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import progress_bar, say, say_files, say_json


def render(
    scene: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    mesh: Path | None = None,
    size: Whole | None = None,
    json: bool = False,
) -> None:
    """Draw a scene in spectrally computed colour.

    Radiance is computed at every vertex on 61 wavelengths and shown through CIE
    XYZ as sRGB.

    Example: skinviz render scene.toml -o hand.png --mesh hand.vtp --size 1024

    Parameters
    ----------
    scene
        Scene file (TOML).
    out
        Picture to write, .png.
    mesh
        Mesh to write with pigments, radiance and colour at every vertex, .vtp.
    size
        Longer side of the picture in pixels, instead of the scene's size.
    json
        Print the files and what the display could not show as JSON.
    """
    import dataclasses

    import numpy as np

    from skinviz._validate import in_range, one_of
    from skinviz.rendering.shade import shade
    from skinviz.scan.formats import write_mesh
    from skinviz.scene.camera import LARGEST_PICTURE
    from skinviz.scene.scene_file import read_scene
    from skinviz.view.offscreen import draw, save_picture

    one_of(out.suffix.lower(), (".png",), "suffix of --out")
    if mesh is not None:
        one_of(mesh.suffix.lower(), (".vtp",), "suffix of --mesh")
    with progress_bar(4) as begin:
        begin("read scene")
        described = read_scene(scene)
        if size is not None:
            in_range(size, 1, LARGEST_PICTURE, "--size", "pixels")
            old = described.camera.size
            new = np.maximum(1, np.round(np.multiply(old, size / max(old)))).astype(int)
            camera = dataclasses.replace(
                described.camera, size=(int(new[0]), int(new[1]))
            )
            described = described.replace(camera=camera)
        begin("shade")
        shaded = shade(described)
        begin("draw")
        picture = draw(shaded, described.camera)
        begin("write")
        files = [save_picture(picture, out)]
        if mesh is not None:
            files.append(write_mesh(mesh, shaded))
    counts = {
        name: int(shaded.field_data[name][0])
        for name in ("facing", "over_exposed", "out_of_gamut")
    }
    if json:
        say_json({"files": [str(f) for f in files], "vertices": counts})
    else:
        say_files(files)
        for name in ("over_exposed", "out_of_gamut"):
            if counts[name]:
                share = counts[name] / counts["facing"]
                say(
                    f"note: {counts[name]} vertices, {share:.1%} of those that face "
                    f"the viewer, are {name.replace('_', '-')} on sRGB"
                )
