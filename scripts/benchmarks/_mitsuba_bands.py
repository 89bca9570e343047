"""The spectrum of every pixel: our cube of 61 bands against Mitsuba's spectral film."""

import time

import _mitsuba_scene
import numpy as np
from _mitsuba_race import say
from _mitsuba_scene import BEST_SAMPLER, Material, Setting
from _print import Row

from skinviz.rendering.geometry import Geometry
from skinviz.rendering.plan import Plan
from skinviz.rendering.render import render
from skinviz.rendering.spectral import light_spectra
from skinviz.scene.scene import Scene

_SPP = 64
_TURNS = 3


def rows(scene: Scene, geometry: Geometry, setting: Setting, material: Material):
    """Yield time and error of both, and how far the mean spectra are apart."""
    say(f"spectral film, {_SPP} samples a pixel")
    film = _mitsuba_scene.spectral_film(setting.wavelengths)
    peer = _mitsuba_scene.hand(setting, material, BEST_SAMPLER, film)
    _mitsuba_scene.render(peer, _SPP, 9)
    (first, one), (second, other) = (
        _mitsuba_scene.timed(peer, _SPP, seed) for seed in (1, 2)
    )
    seconds, coarse, fine, inside = _ours(scene, geometry)
    theirs = (first + second) / 2
    noise = _apart(first[inside], second[inside]) / np.sqrt(2)
    yield Row(
        f"61 bands of each of {inside.size} pixels: Mitsuba's spectral film, "
        f"{BEST_SAMPLER}, {_SPP} samples; time, RMS noise of a spectrum",
        "–",
        f"{1e3 * min(one, other):.0f} ms, {noise:.1%}",
    )
    yield Row(
        "– skinviz, 1 sample, colours and cube; time, RMS difference to 16 samples",
        "–",
        f"{1e3 * seconds:.0f} ms, {_apart(coarse[inside], fine[inside]):.1%}; "
        f"{min(one, other) / seconds:.0f} × faster",
    )
    plate = _mitsuba_scene.render(_mitsuba_scene.white(setting, film), 16, 1)
    seen = theirs[inside].mean(axis=0) / plate.mean(axis=(0, 1))
    own = fine[inside].astype(float).mean(axis=0) / light_spectra(scene)[0]
    yield Row(
        "– the hand's mean spectrum, Mitsuba over skinviz, largest deviation of a band",
        "–",
        f"{np.abs(seen / own - 1).max():.2%}",
    )


def _ours(scene: Scene, geometry: Geometry):
    """Return the time of our cube with one sample, it, the finest, and where."""
    buffer = np.zeros((*scene.camera.size[::-1], scene.wavelengths.size), np.float32)
    times = []
    for _ in range(_TURNS + 1):
        start = time.perf_counter()
        coarse = render(scene, Plan(samples=1), geometry=geometry)
        coarse.radiance(out=buffer)
        times.append(time.perf_counter() - start)
    fine = render(scene, Plan(samples=16), geometry=geometry)
    inside = (fine.coverage == 1) & (fine.xyz[..., 1] > 0)
    return min(times[1:]), buffer, fine.radiance(), inside


def _apart(spectra: np.ndarray, other: np.ndarray) -> float:
    """Return the RMS difference of spectra over their RMS."""
    size = np.square(spectra.astype(float) + other).mean() / 4
    return float(np.sqrt(np.square(spectra.astype(float) - other).mean() / size))
