"""``skinviz demo``: the main job, from raw scan to figures, on shipped data."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.output import (
    progress_bar,
    require_folder,
    say,
    say_files,
    say_json,
    versions,
    write_json,
)

if TYPE_CHECKING:
    import xarray

    from skinviz.rendering.render import Rendering
    from skinviz.scene.scene import Scene
    from skinviz.view.figures import Site

ORIGIN, SUBJECT = "China", "186"
"""Whose skin the demo shows: of median fit quality, no weight at a bound."""

SITES = ("back of hand", "cheek", "outer arm", "inner arm")
LIGHTS = ("D65", "A")
PICTURE_SIZE = (840, 1100)


def demo(
    *, out: Annotated[Path, Parameter(name=["--out", "-o"])], json: bool = False
) -> None:
    """Run the main job on the data that comes with skinviz.

    A raw range scan of a hand is cleaned, the skin of one person of the ISSA archive
    is fitted, the hand is computed on 61 wavelengths under D65 and A, and figures,
    mesh and report are written.

    Example: skinviz demo --out demo

    Parameters
    ----------
    out
        Folder to write into; made if it does not exist.
    json
        Print the report as JSON.
    """
    from skinviz._system import require_system_libraries

    require_folder(out)
    require_system_libraries("pymeshlab")
    started = time.perf_counter()
    from skinviz.rendering.geometry import geometry_of
    from skinviz.rendering.render import render
    from skinviz.rendering.shade import shade, vertex_spectrum
    from skinviz.scan.clean import STEPS, clean_scan
    from skinviz.scan.formats import read_scan, write_mesh
    from skinviz.scan.shipped import DEMO_SCAN, shipped_mesh
    from skinviz.scene.camera import Camera
    from skinviz.scene.hand import hand_frame
    from skinviz.scene.lights import DirectionalLight
    from skinviz.scene.scene import Scene, Skin
    from skinviz.spectra.archives import load_archive
    from skinviz.surface.torrance_sparrow import TorranceSparrow
    from skinviz.view.figures import (
        MarkedPoint,
        hands_figure,
        save_figure,
        sites_figure,
    )

    with progress_bar(len(STEPS) + 5) as begin:
        begin("read raw views")
        scan = read_scan(shipped_mesh(DEMO_SCAN))
        mesh, cleaning = clean_scan(scan, progress=begin)

        begin("fit spectra")
        archive = load_archive("issa")
        sites = [_site(archive, name) for name in SITES]
        hand = sites[0]

        begin("shade")
        frame = hand_frame(mesh)
        scene = Scene(
            mesh=mesh,
            skin=Skin.from_fit(hand.fit),
            surface=TorranceSparrow(),
            lights=(DirectionalLight(frame.back),),
            camera=Camera(frame.back, frame.fingers, PICTURE_SIZE),
        )
        scenes = {
            name: scene.replace(lights=(DirectionalLight(frame.back, name),))
            for name in LIGHTS
        }
        shaded = shade(scenes[LIGHTS[0]])

        begin("trace rays")
        geometry = geometry_of(mesh)
        pictures = {
            f"illuminant {name}, 0/0": render(s, geometry=geometry)
            for name, s in scenes.items()
        }
        point = _marked_vertex(scene)
        credit = (
            f"ISSA subject {SUBJECT} ({ORIGIN}); Lu et al., Sci. Data 12:487 (2025), "
            "CC BY 4.0"
        )
        hands = hands_figure(
            pictures,
            hand,
            [MarkedPoint(mesh.points[point], vertex_spectrum(scene, point))],
            "Two-layer Kubelka–Munk skin, Torrance–Sparrow surface, 61 wavelengths "
            f"through CIE XYZ.  Spectrum: {credit}.  Hand: MakeHuman, CC0, simulated "
            "range scan.",
        )
        compared = sites_figure(
            sites,
            f"Four body sites of ISSA subject {SUBJECT} ({ORIGIN}): measured and "
            "fitted, 95 % intervals of the weights",
            f"Specular {archive.attrs['specular']} (8°/sphere), 400–700 nm at 10 nm.  "
            f"{credit}.",
        )

        begin("write")
        files = [
            save_figure(hands, out / "hand.png"),
            save_figure(compared, out / "sites.png"),
            write_mesh(out / "hand.vtp", shaded),
        ]
        report = _report(cleaning.to_dict(), sites, pictures, point)
        report["seconds"]["total"] = round(time.perf_counter() - started, 2)
        files.append(write_json(out / "report.json", report))
    if json:
        say_json({**report, "files": [str(file) for file in files]})
        return
    say(str(cleaning))
    for site in sites:
        say(_line(site))
    say_files(files)


def _site(archive: xarray.Dataset, name: str) -> Site:
    """Return one body site of the demo's subject, measured and fitted."""
    from skinviz.skin.fit import fit_skin
    from skinviz.skin.models import skin_model
    from skinviz.view.figures import Site

    chosen = (
        (archive.origin == ORIGIN)
        & (archive.subject == SUBJECT)
        & (archive.site == name)
    )
    spectrum = archive.reflectance.values[chosen.values].mean(axis=0)
    model = skin_model(site=name, specular=archive.attrs["specular"])
    fit = fit_skin(spectrum, archive.wavelength.values, model)
    inside = archive.wavelength.isin(fit.wavelengths).values
    return Site(name, spectrum[inside], fit)


def _marked_vertex(scene: Scene) -> int:
    """Return the vertex of the back of the hand that shines most."""
    import numpy as np

    from skinviz.rendering.shade import vertex_gloss

    along = np.asarray(scene.mesh.points) @ scene.camera.up
    share = (along - along.min()) / np.ptp(along)
    on_back = (share > 0.2) & (share < 0.5)
    return int(np.argmax(np.where(on_back, vertex_gloss(scene), -1.0)))


def _report(
    cleaning: dict[str, Any],
    sites: list[Site],
    pictures: dict[str, Rendering],
    point: int,
) -> dict[str, Any]:
    """Return everything that the demo found, as plain data."""
    from dataclasses import asdict

    from skinviz.scene.describe import describe
    from skinviz.skin.report import fit_to_dict

    seconds = {step["name"]: step["seconds"] for step in cleaning["steps"]}
    return {
        "subject": {"archive": "issa", "origin": ORIGIN, "subject": SUBJECT},
        "fits": {site.name: _fit(fit_to_dict(site.fit, [site.name])) for site in sites},
        "cleaning": cleaning["steps"],
        "pictures": {
            title: {
                "scene": describe(picture.scene),
                "plan": asdict(picture.plan),
                "counts": asdict(picture.counts),
            }
            for title, picture in pictures.items()
        },
        "marked_vertex": point,
        "seconds": seconds,
        "versions": versions(),
    }


def _fit(data: dict[str, Any]) -> dict[str, Any]:
    """Return the model and the only fit of a report."""
    model = {key: value for key, value in data.items() if key not in ("format", "fits")}
    return {**model, **data["fits"][0]}


def _line(site: Site) -> str:
    """Return one line about a site's fit."""
    fit = site.fit
    weights = "  ".join(
        f"{name} {value:.4f} [{low:.4f}, {high:.4f}]"
        for name, value, (low, high) in zip(
            fit.parameters, fit.values, fit.interval, strict=True
        )
    )
    return (
        f"{site.name:<13} {weights}  SSE(61) {float(fit.sse_61):.4f}  "
        f"RMSE {float(fit.rmse):.4f}  "
        f"dE00 {float(fit.delta_e):.2f}  {fit.status}"
    )
