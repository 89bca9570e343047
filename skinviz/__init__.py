"""skinviz: what skin is made of, and what it looks like.

Range-scanned hands are cleaned, pigment weights are fitted to measured spectra
with two Kubelka–Munk layers, spectral radiance is computed with Torrance–Sparrow
shading, and hands are shown in colour with their spectra beside them. The method
is that of Doi, Tanaka & Tominaga, J. Imaging Sci. Technol. 49:574 (2005).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from skinviz.errors import (
        ArgumentError,
        DataError,
        FitError,
        MeshError,
        SceneWarning,
        SkinvizError,
        SystemLibraryError,
    )
    from skinviz.instruments.derive import read_session
    from skinviz.instruments.errors import InstrumentError
    from skinviz.rendering.files import read_picture_metadata
    from skinviz.rendering.geometry import geometry_of
    from skinviz.rendering.plan import Plan
    from skinviz.rendering.planner import plan
    from skinviz.rendering.render import Rendering, render
    from skinviz.rendering.shade import shade, vertex_spectrum
    from skinviz.scan.clean import clean_scan
    from skinviz.scan.formats import read_mesh, read_scan, write_mesh
    from skinviz.scan.report import CleaningReport
    from skinviz.scan.scan import Scan
    from skinviz.scan.simulate import Scanner, simulate_scan
    from skinviz.scene.camera import Camera
    from skinviz.scene.hand import HandFrame, hand_frame
    from skinviz.scene.landmarks import landmarks
    from skinviz.scene.lights import DirectionalLight, PointLight
    from skinviz.scene.painted import painted_image, painted_vertices
    from skinviz.scene.pigment_map import pigment_map
    from skinviz.scene.relief import Relief
    from skinviz.scene.scene import Scene, Skin
    from skinviz.scene.scene_file import read_scene
    from skinviz.scene.texture import SkinTexture, textured
    from skinviz.skin.fit import fit_skin
    from skinviz.skin.kubelka_munk import kubelka_munk_layer
    from skinviz.skin.models import skin_model, skin_models
    from skinviz.skin.skin_fit import SkinFit
    from skinviz.spectra.archives import load_archive
    from skinviz.spectra.display import SRGB, Display, measured_display, read_icc
    from skinviz.spectra.display_file import read_display
    from skinviz.spectra.files import read_spectra, write_spectra
    from skinviz.spectra.illuminants import (
        Illuminant,
        black_body,
        illuminants,
        line_lamp,
        read_illuminant,
    )
    from skinviz.study.archive_study import archive_study
    from skinviz.study.comparing import compare_study
    from skinviz.study.comparison import Comparison
    from skinviz.study.study import Study
    from skinviz.study.study_file import read_study
    from skinviz.surface.cook_torrance import CookTorrance
    from skinviz.surface.fitted_lobe import LobeFit
    from skinviz.surface.gonio import read_gonio
    from skinviz.surface.lambert import Lambert
    from skinviz.surface.lobe_fit import alpha_from_diffuse, fit_lobe
    from skinviz.surface.models import surface_model, surface_models
    from skinviz.surface.phong import Phong
    from skinviz.surface.torrance_sparrow import TorranceSparrow
    from skinviz.view.gallery.catalogue import GalleryFigure, figure
    from skinviz.view.viewer.show import show

# Loaded when first used, so that ``import skinviz`` costs next to nothing.
_HOME = {
    "ArgumentError": "errors",
    "DataError": "errors",
    "FitError": "errors",
    "MeshError": "errors",
    "SceneWarning": "errors",
    "SkinvizError": "errors",
    "SystemLibraryError": "errors",
    "read_session": "instruments.derive",
    "InstrumentError": "instruments.errors",
    "read_picture_metadata": "rendering.files",
    "geometry_of": "rendering.geometry",
    "Plan": "rendering.plan",
    "plan": "rendering.planner",
    "Rendering": "rendering.render",
    "render": "rendering.render",
    "shade": "rendering.shade",
    "vertex_spectrum": "rendering.shade",
    "CleaningReport": "scan.report",
    "clean_scan": "scan.clean",
    "read_mesh": "scan.formats",
    "read_scan": "scan.formats",
    "write_mesh": "scan.formats",
    "Scan": "scan.scan",
    "Scanner": "scan.simulate",
    "simulate_scan": "scan.simulate",
    "HandFrame": "scene.hand",
    "hand_frame": "scene.hand",
    "Camera": "scene.camera",
    "landmarks": "scene.landmarks",
    "DirectionalLight": "scene.lights",
    "PointLight": "scene.lights",
    "painted_image": "scene.painted",
    "painted_vertices": "scene.painted",
    "pigment_map": "scene.pigment_map",
    "Relief": "scene.relief",
    "Scene": "scene.scene",
    "Skin": "scene.scene",
    "read_scene": "scene.scene_file",
    "SkinTexture": "scene.texture",
    "textured": "scene.texture",
    "SkinFit": "skin.skin_fit",
    "fit_skin": "skin.fit",
    "kubelka_munk_layer": "skin.kubelka_munk",
    "skin_model": "skin.models",
    "skin_models": "skin.models",
    "load_archive": "spectra.archives",
    "read_spectra": "spectra.files",
    "write_spectra": "spectra.files",
    "Comparison": "study.comparison",
    "Study": "study.study",
    "archive_study": "study.archive_study",
    "compare_study": "study.comparing",
    "read_study": "study.study_file",
    "SRGB": "spectra.display",
    "Display": "spectra.display",
    "measured_display": "spectra.display",
    "read_display": "spectra.display_file",
    "read_icc": "spectra.display",
    "Illuminant": "spectra.illuminants",
    "black_body": "spectra.illuminants",
    "illuminants": "spectra.illuminants",
    "line_lamp": "spectra.illuminants",
    "read_illuminant": "spectra.illuminants",
    "CookTorrance": "surface.cook_torrance",
    "LobeFit": "surface.fitted_lobe",
    "read_gonio": "surface.gonio",
    "Lambert": "surface.lambert",
    "alpha_from_diffuse": "surface.lobe_fit",
    "fit_lobe": "surface.lobe_fit",
    "Phong": "surface.phong",
    "surface_model": "surface.models",
    "surface_models": "surface.models",
    "TorranceSparrow": "surface.torrance_sparrow",
    "GalleryFigure": "view.gallery.catalogue",
    "figure": "view.gallery.catalogue",
    "show": "view.viewer.show",
}

__all__ = ["__version__", *sorted(_HOME)]  # noqa: PLE0604 - names are in _HOME


def __getattr__(name: str) -> Any:
    """Load a public name's module when the name is first used."""
    if name not in _HOME:
        raise AttributeError(f"module 'skinviz' has no attribute {name!r}")
    return getattr(import_module(f"skinviz.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
