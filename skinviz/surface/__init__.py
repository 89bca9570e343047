"""Reflection at the skin's surface: Fresnel's law and the models of rough surfaces."""

from skinviz.surface.cook_torrance import CookTorrance
from skinviz.surface.dispersion import Dispersion, dispersion, dispersions
from skinviz.surface.energy import specular_albedo
from skinviz.surface.fitted_lobe import LobeFit
from skinviz.surface.fresnel import fresnel_reflectance
from skinviz.surface.gonio import GonioData, read_gonio
from skinviz.surface.lambert import Lambert
from skinviz.surface.lobe_fit import alpha_from_diffuse, fit_lobe
from skinviz.surface.models import surface_model, surface_models
from skinviz.surface.phong import Phong
from skinviz.surface.surface import Surface
from skinviz.surface.torrance_sparrow import TorranceSparrow, physical_beta

__all__ = [
    "CookTorrance",
    "Dispersion",
    "GonioData",
    "Lambert",
    "LobeFit",
    "Phong",
    "Surface",
    "TorranceSparrow",
    "alpha_from_diffuse",
    "dispersion",
    "dispersions",
    "fit_lobe",
    "fresnel_reflectance",
    "physical_beta",
    "read_gonio",
    "specular_albedo",
    "surface_model",
    "surface_models",
]
