"""Mitsuba against the formulas: is what we ask of it what we mean?"""

from dataclasses import replace

import mitsuba as mi
import numpy as np
from _mitsuba_formula import beckmann_facets, half_and_half, lambertian
from _mitsuba_scene import Material, Setting, ball, bsdf, render, white
from _print import Row

from skinviz.scene.camera import Camera
from skinviz.spectra.colorimetry import xyz_weights

_GRID = 16  # places in a pixel, along each side, where the formula is evaluated


def rows(setting: Setting, materials: dict[str, Material], surface):
    """Yield how far Mitsuba, and our rough surface, are from the formulas."""
    ours = xyz_weights(setting.wavelengths, setting.spd).sum(axis=0)
    theirs = render(white(_small(setting)), 256, 1).mean(axis=(0, 1))
    apart = np.abs(theirs / theirs[1] - ours).max()
    yield Row("perfect diffuser's X and Z for Y = 1, Mitsuba's less ours", "–",
              f"{apart:.1e}")  # fmt: skip
    for name, material in materials.items():
        yield Row(
            f"{name}: Mitsuba's BSDF against the formula, 200 pairs of directions",
            "1e-5",
            f"{_directions(setting, material):.1e} relative",
        )
        mean, largest = _sphere(setting, material)
        yield Row(
            f"{name}: Mitsuba's picture of a sphere against the formula, Y of 1",
            "–",
            f"mean {mean:.1e}, largest {largest:.1e}",
        )

    yield Row(
        "half rough: skinviz's surface against the formula, 200 pairs of directions",
        "1e-5",
        f"{_ours(surface):.1e} relative",
    )


def _ours(surface) -> float:
    """Return the largest error of half of our rough surface, relative down to 1e-12."""
    L, V = _pairs(200)
    N = np.array([0.0, 0.0, 1.0])
    exact = 0.5 * beckmann_facets(N, L, V, surface.roughness, surface.n)
    apart = np.abs(surface.evaluate(N, L, V) - exact)
    return float((apart / np.maximum(exact, 1e-12)).max())


def _pairs(n: int) -> np.ndarray:
    """Return pairs of directions (2, n, 3) on the side of +z."""
    pairs = np.random.default_rng(1).normal(size=(2, n, 3))
    pairs[..., 2] = np.abs(pairs[..., 2])
    return pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)


def _directions(setting: Setting, material: Material) -> float:
    """Return the largest relative error of the BSDF at random directions and bands."""
    rng = np.random.default_rng(1)
    plugin = mi.load_dict(bsdf(material, setting.wavelengths))
    worst = 0.0
    for L, V in _pairs(200).swapaxes(0, 1):
        band = rng.integers(setting.wavelengths.size)
        at = mi.SurfaceInteraction3f()
        at.wi = mi.Vector3f(V.tolist())
        at.wavelengths = mi.Spectrum(float(setting.wavelengths[band]))
        value = plugin.eval(mi.BSDFContext(), at, mi.Vector3f(L.tolist()))
        got = np.pi * np.ravel(np.array(value))[0]
        want = _formula(material, np.array([0.0, 0.0, 1.0]), L, V, band)
        worst = max(worst, abs(got / want - 1))
    return worst


def _sphere(setting: Setting, material: Material) -> tuple[float, float]:
    """Return the mean and largest error in Y of a sphere's picture, its rim apart."""
    small = _small(setting)
    radius = 0.45 * small.view.pixel * small.view.size[1]
    flat = Material(np.full(setting.wavelengths.size, 0.5), material.roughness)
    seen = render(ball(small, flat, radius), 4096, 1)[..., 1]
    seen /= render(white(small), 256, 2)[..., 1].mean()
    side = small.view.size[0] * _GRID
    place = ((np.arange(side) + 0.5) / side - 0.5) * small.view.size[0]
    x, y = np.meshgrid(place * small.view.pixel, -place * small.view.pixel)
    inside = radius**2 - x**2 - y**2
    height = np.sqrt(np.maximum(inside, 0))
    axes = np.stack([small.view.right, small.view.up, small.view.direction])
    N = np.stack([x, y, height], axis=-1) @ axes / radius
    exact = _formula(flat, N, small.light, small.view.direction, 0)
    exact, whole = _pixels(exact).mean(axis=(1, 3)), _pixels(inside).min(axis=(1, 3))
    apart = np.abs(seen - exact)[whole > 0]
    return float(apart.mean()), float(apart.max())


def _formula(material: Material, N, L, V, band: int):
    """Return what the material should show."""
    reflectance = material.reflectance[band]
    if material.roughness is None:
        return lambertian(N, L, reflectance)
    return half_and_half(
        N, L, V,
        reflectance=reflectance, roughness=material.roughness, n=material.n,
    )  # fmt: skip


def _pixels(fine: np.ndarray) -> np.ndarray:
    """Return places (rows, down, columns, across) of pixels."""
    n = fine.shape[0] // _GRID
    return fine.reshape(n, _GRID, n, _GRID)


def _small(setting: Setting) -> Setting:
    """Return the setting in a picture of 64 × 64."""
    view = setting.view
    camera = Camera(view.direction, view.up, (64, 64), target=view.target, height=200.0)
    return replace(setting, view=camera.view(setting.points))
