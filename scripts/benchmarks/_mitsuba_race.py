"""Both programs at several numbers of samples: time and error of each picture.

A time is of one call that returns the picture's colours: skinviz's ``render`` with the
geometry prepared, Mitsuba's ``render`` of a loaded scene and the copy of its film.
Reading meshes, building trees for rays and compiling are done before.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import _mitsuba_scene
import numpy as np
from _mitsuba_error import Point, colour_map, difference
from _mitsuba_scene import BEST_SAMPLER, DEFAULT_SAMPLER, Material, Setting
from _print import race

from skinviz.rendering.geometry import Geometry
from skinviz.rendering.plan import SAMPLES, Plan
from skinviz.rendering.render import render
from skinviz.scene.scene import Scene
from skinviz.spectra.colorimetry import xyz_weights

_SHORT = 64  # samples a pixel up to which Mitsuba is timed in turns with us
_TURNS = 9


@dataclass(frozen=True, eq=False)
class Race:
    """Points by who made them, and the best pictures.

    ``reference`` is the mean of two of Mitsuba's pictures with ``spp`` samples each,
    ``noise`` what it is itself off by, ``map`` ΔE00 between it and ``picture``, ours.
    """

    curves: dict[str, list[Point]]
    picture: np.ndarray
    reference: np.ndarray
    spp: int
    noise: float
    map: np.ndarray
    inside: np.ndarray


def run(
    scene: Scene,
    geometry: Geometry,
    setting: Setting,
    material: Material,
    *,
    spps: list[int],
    best: int,
) -> Race:
    """Make all pictures of one material, the reference's of ``best`` samples."""
    peers = {
        name: _mitsuba_scene.hand(setting, material, name)
        for name in (DEFAULT_SAMPLER, BEST_SAMPLER)
    }
    plate = _mitsuba_scene.render(_mitsuba_scene.white(setting), 256, 1)
    scale = 1 / plate[..., 1].mean()
    ours = {k: _maker(scene, geometry, k) for k in sorted(SAMPLES)}
    seconds = _in_turns(ours, peers, spps)
    say(f"reference, 2 x {best} samples a pixel")
    two = [scale * _mitsuba_scene.render(peers[BEST_SAMPLER], best, s) for s in (3, 4)]
    reference = (two[0] + two[1]) / 2
    pictures = {k: make() for k, make in ours.items()}
    finest = pictures[max(SAMPLES)]
    inside = (finest.coverage == 1) & (reference[..., 1] > 0)
    white = xyz_weights(setting.wavelengths, setting.spd).sum(axis=0)

    def off(xyz: np.ndarray, other: np.ndarray = reference) -> np.ndarray:
        return colour_map(xyz, other, white, inside)

    curves = {"skinviz": [
        Point(k, seconds["skinviz", k], difference(off(picture.xyz)))
        for k, picture in pictures.items()
    ]}  # fmt: skip
    for name, peer in peers.items():
        curves[f"Mitsuba, {name}"] = [
            _peer_point(peer, spp, seconds.get((name, spp)), scale, off)
            for spp in possible(name, spps)
        ]
    picture = np.asarray(finest.xyz, dtype=np.float64)
    noise = difference(off(*two)).mean / 2
    return Race(curves, picture, reference, best, noise, off(picture), inside)


def possible(sampler: str, spps: list[int]) -> list[int]:
    """Return the numbers that a sampler takes: the best one rounds 1 up to 4."""
    return [spp for spp in spps if spp > 1 or sampler != BEST_SAMPLER]


def _maker(scene: Scene, geometry: Geometry, samples: int) -> Callable[[], object]:
    """Return the call that makes our picture."""
    plan = Plan(samples=samples)
    return lambda: render(scene, plan, geometry=geometry)


def _in_turns(ours: dict, peers: dict, spps: list[int]) -> dict:
    """Return the least time of our pictures and of Mitsuba's short ones. [s]"""

    def maker(peer, spp: int) -> Callable[[], object]:
        return lambda: _mitsuba_scene.render(peer, spp, 99)

    say("timing in turns")
    makers = {("skinviz", k): make for k, make in ours.items()}
    for name, peer in peers.items():
        for spp in possible(name, spps):
            if spp <= _SHORT:
                makers[name, spp] = maker(peer, spp)
    return race(makers, _TURNS)


def _peer_point(
    peer, spp: int, seconds: float | None, scale: float, off: Callable
) -> Point:
    """Return time, error and noise of Mitsuba with some samples.

    Two seeds' pictures differ by √2 times the noise of one. A long picture's time is
    the least of any of its passes, times their number.
    """
    say(f"Mitsuba, {spp} samples a pixel")
    (first, one), (second, other) = (_mitsuba_scene.timed(peer, spp, s) for s in (1, 2))
    first, second = scale * first, scale * second
    noise = difference(off(first, second)).mean / np.sqrt(2)
    taken = min(one, other) if seconds is None else seconds
    return Point(spp, taken, difference(off(first)), float(noise))


def say(what: str) -> None:
    """Tell who waits what is being done."""
    print(f"{what} ...", file=sys.stderr)
