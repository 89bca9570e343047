"""One tissue by radiative transport and by Kubelka–Munk: spectra, colours, fits.

For ``transport.py`` beside this file, which says what for and prints the tables.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skinviz.skin.coefficients import layer_thickness, load_coefficients
from skinviz.skin.fit import fit_skin
from skinviz.skin.interface import Interface, interface
from skinviz.skin.kubelka_munk import kubelka_munk_layer
from skinviz.skin.models import skin_model
from skinviz.skin.scattering_rules import SCATTERING_RULES
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab

# The oracle is no part of the package.
sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from oracles import transport

WAVELENGTHS = np.arange(400.0, 701.0, 10.0)
MELANIN = np.array([0.01, 0.03, 0.06, 0.12, 0.2, 0.3, 0.43])
BLOOD, SATURATION = (0.002, 0.01, 0.03, 0.07), (0.3, 0.6, 0.9)
DERMIS = np.array([(0.0, 0.6)] + [(b, s) for b in BLOOD for s in SATURATION])
SKIN_INDEX = 1.4
FITTED_RULES = ("gate", "meador_weaver", "toon")
"""Rules whose K is proportional to μ_a and S free of it: weights stay weights."""


@dataclass(frozen=True, eq=False)
class Tissue:
    """Transport coefficients of the two layers; wavelength on the last axis.

    mu_a: of each epidermis (M, n) and dermis (B, n); mu_s_prime: (n,) of the two;
    g: (n,). [mm⁻¹]
    """

    mu_a: tuple[np.ndarray, np.ndarray]
    mu_s_prime: tuple[np.ndarray, np.ndarray]
    g: np.ndarray


def textbook_tissue() -> Tissue:
    """Return what the textbook set was made from: μ_a = K/2, μ_s′ = 4S/3."""
    at = load_coefficients("textbook").at(WAVELENGTHS)
    blood, saturation = DERMIS[:, :1], DERMIS[:, 1:]
    dermis = saturation * at.oxyhaemoglobin + (1 - saturation) * at.deoxyhaemoglobin
    return Tissue(
        mu_a=(MELANIN[:, None] * at.melanin / 2, blood * dermis / 2),
        mu_s_prime=(at.epidermis * 4 / 3, at.dermis * 4 / 3),
        g=0.62 + 0.29e-3 * WAVELENGTHS,  # van Gemert et al. 1989
    )


def by_transport(tissue, sites, n, points=transport.POINTS):
    """Return reflectance (site, M, B, n) for a beam and for diffuse light."""
    shape = (len(sites), *(len(a) for a in tissue.mu_a), len(tissue.g))
    found = np.zeros((2, *shape))
    how = {"n": n, "points": points}
    white = transport.lambertian(1.0, points)
    for i, site in enumerate(sites):
        for w, g in enumerate(tissue.g):
            layers = [
                [
                    transport.layer(a[w], s[w] / (1 - g), g, depth, **how)
                    for a in absorptions
                ]
                for absorptions, s, depth in zip(
                    tissue.mu_a, tissue.mu_s_prime, layer_thickness(site), strict=True
                )
            ]
            for k, dermis in enumerate(layers[1]):
                base = transport.over(dermis, white, **how)
                for m, epidermis in enumerate(layers[0]):
                    skin = transport.over(epidermis, base, **how)
                    found[:, i, m, k, w] = transport.emerging(skin, **how)
    return transport.Fluxes(*found)


def by_kubelka_munk(tissue, sites, rule):
    """Return R_b (site, M, B, n) with a rule's K and S; NaN outside its range."""
    layers = []
    for a, s in zip(tissue.mu_a, tissue.mu_s_prime, strict=True):
        # Star's S is negative beyond: such tissue is left out, not clipped.
        inside = (a <= 3 * s) | (rule != "star")
        K, S = SCATTERING_RULES[rule](np.where(inside, a, 0.0), s)
        layers.append((K, S, inside))
    (K_e, S_e, in_e), (K_d, S_d, in_d) = layers
    inside = in_e[:, None] & in_d
    spectra = []
    for site in sites:
        d_e, d_d = layer_thickness(site)
        R_e, T_e = (x[:, None] for x in kubelka_munk_layer(K_e, S_e, d_e))
        R_d, T_d = kubelka_munk_layer(K_d, S_d, d_d)
        base = R_d + T_d**2 / (1 - R_d)
        spectra.append(R_e + T_e**2 * base / (1 - R_e * base))
    return np.where(inside, np.array(spectra), np.nan)


def diffuse_interface(n=SKIN_INDEX):
    """Return Saunderson's form for diffuse light from outside."""
    inside = interface("included").internal
    outside = 1 - n**2 * (1 - inside)
    return Interface(outside, (1 - outside) * (1 - inside), inside)


def colour_difference(reflectance, other):
    """Return ΔE00 (...) under D65 with the perfect diffuser as white."""
    white = spectrum_to_xyz(np.ones(len(WAVELENGTHS)), WAVELENGTHS)
    known = np.isfinite(reflectance).all(axis=-1) & np.isfinite(other).all(axis=-1)
    labs = [
        xyz_to_lab(spectrum_to_xyz(r[known], WAVELENGTHS), white)
        for r in (reflectance, other)
    ]
    found = np.full(known.shape, np.nan)
    found[known] = delta_e_2000(*labs)
    return found


def differences(model, truth):
    """Return skins compared, mean, RMS and largest ΔR, mean and largest ΔE00."""
    delta_e = colour_difference(model, truth)
    known = np.isfinite(delta_e)
    if not known.any():
        return (0, *[np.nan] * 5)
    delta = (model - truth)[known]
    return (
        int(known.sum()),
        delta.mean(),
        np.sqrt((delta**2).mean()),
        np.abs(delta).max(),
        delta_e[known].mean(),
        delta_e[known].max(),
    )


def fit(measured, sites, rule, specular):
    """Return the SkinFit of each site's spectra (M, B, n) with a rule's table."""
    table = load_coefficients("textbook")
    convert = SCATTERING_RULES[rule]
    of_pigments = {
        name: convert(getattr(table, name) / 2, 1.0).K
        for name in ("melanin", "oxyhaemoglobin", "deoxyhaemoglobin")
    }
    of_tissues = {
        name: convert(0.0, getattr(table, name) * 4 / 3).S
        for name in ("epidermis", "dermis")
    }
    own = replace(table, name=rule, **of_pigments, **of_tissues)
    fits = []
    for spectra, site in zip(measured, sites, strict=True):
        model = skin_model(site=site, specular=specular, coefficients="textbook")
        fits.append(fit_skin(spectra, WAVELENGTHS, replace(model, coefficients=own)))
    return fits
