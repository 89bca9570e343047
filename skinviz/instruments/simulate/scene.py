"""What simulated instruments look at: one lamp, tile and skin, shared by all."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from skinviz.instruments.arrangement import SAMPLE, STATES, Arrangement
from skinviz.instruments.simulate import optics

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Subject:
    """Skin as arrays, from whatever model.

    Attributes
    ----------
    wavelengths, reflectance : (n,) ndarray
        Of the body, without the surface. [nm], [1]
    illumination, viewing : (i,) and (v,) ndarray
        Angles at which the lobe is told, illumination negative on the viewer's side.
        [degrees]
    lobe : (i, v) ndarray
        Specular part in units of the perfect diffuser that faces the lamp. [1]
    n : float
        Refractive index, which polarises. [1]
    """

    wavelengths: Array
    reflectance: Array
    illumination: Array
    viewing: Array
    lobe: Array
    n: float = 1.4

    def specular(self, illumination: float, viewing: float) -> float:
        """Return the lobe between the angles [degrees] that it is told at."""
        along = [np.interp(viewing, self.viewing, row) for row in self.lobe]
        return float(np.interp(illumination, self.illumination, along))


@dataclass(frozen=True, eq=False)
class Lamp:
    """A halogen lamp by default.

    Attributes
    ----------
    wavelengths, radiance : (n,) ndarray
        Of the perfect diffuser that faces it. [nm], [W sr⁻¹ m⁻² nm⁻¹]
    drift : float
        Change in an hour. [1/h]
    warm_up, settling : float
        What it lacks at first, and how fast that goes. [1], [s]
    """

    wavelengths: Array
    radiance: Array
    drift: float = -0.01
    warm_up: float = 0.02
    settling: float = 60.0

    def output(self, seconds: float) -> float:
        """Return its light after so many seconds, as a share."""
        cold = self.warm_up * np.exp(-seconds / self.settling)
        return float(1 + self.drift * seconds / 3600 - cold)


def halogen(temperature: float = 2900.0, level: float = 0.05) -> Lamp:
    """Return a lamp like a black body [K] of a level [W sr⁻¹ m⁻² nm⁻¹] at 780 nm."""
    nm = np.arange(360.0, 801.0)
    planck = nm**-5.0 / np.expm1(1.438777e7 / (nm * temperature))
    return Lamp(nm, level * planck / planck[nm == 780.0])


class RealTime:
    """Time that passes by itself."""

    def __init__(self) -> None:
        """Begin now."""
        self._zero = time.monotonic()

    def now(self) -> float:
        """Return the seconds since the beginning."""
        return time.monotonic() - self._zero

    def elapse(self, seconds: float) -> None:
        """Let so many seconds pass."""
        time.sleep(seconds)

    def tick(self) -> None:
        """Let the time pass that a question takes: it does so by itself."""


class QuickTime:
    """Time that passes only when something takes time."""

    def __init__(self) -> None:
        """Begin."""
        self._now = 0.0

    def now(self) -> float:
        """Return the seconds since the beginning."""
        return self._now

    def elapse(self, seconds: float) -> None:
        """Let so many seconds pass."""
        self._now += seconds

    def tick(self) -> None:
        """Let the time pass that a question takes."""
        self._now += 0.5


@dataclass(eq=False)
class Bench:
    """The scene that all simulated instruments share.

    Attributes
    ----------
    subject : Subject
        The skin.
    tile : (n, 2) pair of ndarray
        Wavelengths and true radiance factor of the white tile. [nm], [1]
    lamp : Lamp
        The light.
    ambient : float
        Stray light as a share of the lamp's. [1]
    shot, read : float
        Noise of a reading at its brightest band that follows the light, and that does
        not, relatively. [1]
    leakage : float
        Of the polarisers. [1]
    grating : float
        How much more the meter sees of s than of p, halved. [1]
    exposure : float
        Time that a reading takes. [s]
    seed : int
        Of the noise.
    """

    subject: Subject
    tile: tuple[Array, Array]
    lamp: Lamp = field(default_factory=halogen)
    ambient: float = 0.002
    shot: float = 0.004
    read: float = 0.0003
    leakage: float = 0.001
    grating: float = 0.02
    exposure: float = 2.0
    seed: int = 0
    time: RealTime | QuickTime = field(default_factory=RealTime)
    arrangement: Arrangement = field(default_factory=Arrangement)
    darkest: float = 1e-7

    def __post_init__(self) -> None:
        """Begin the noise."""
        self.rng = np.random.default_rng(self.seed)

    def arrange(self, arrangement: Arrangement) -> None:
        """Arrange the bench."""
        self.arrangement = arrangement

    def turn(self, degrees: float) -> None:
        """Turn the lamp; a stage's whole steps may end a hair too far."""
        within = min(max(degrees, -85.0), 85.0)
        self.arrangement = replace(self.arrangement, illumination=within)

    def radiance(self, wavelengths: Array) -> Array:
        """Return what a meter sees now, without its noise (n,)."""
        return self._seen(wavelengths, self.arrangement, self.time.now())

    def reading(self, wavelengths: Array, average: int = 1) -> Array:
        """Return what a meter measures now (n,), which takes the exposure's time."""
        begun = self.radiance(wavelengths)
        self.time.elapse(self.exposure * average)
        seen = (begun + self.radiance(wavelengths)) / 2
        full = seen.max()
        sigma = np.sqrt(self.shot**2 * seen * full + (self.read * full) ** 2)
        return np.asarray(seen + self.rng.normal(0, sigma / np.sqrt(average)))

    def _seen(self, nm: Array, how: Arrangement, at: float) -> Array:
        """Return the radiance (n,) of an arrangement at a time."""
        lamp_azimuth, azimuth = STATES[how.state]
        lamp = np.interp(nm, self.lamp.wavelengths, self.lamp.radiance)
        light = optics.polariser(lamp_azimuth, self.leakage) @ optics.UNPOLARISED
        light = light * self.lamp.output(at) * how.lamp
        stray = self.ambient * optics.UNPOLARISED
        cosine = np.cos(np.deg2rad(how.illumination))
        if how.target == SAMPLE:
            told = self.subject
            body = np.interp(nm, told.wavelengths, told.reflectance)
            mirrored = told.specular(how.illumination, how.viewing)
            leaving = self._body(light, how) * cosine + stray
            stokes = np.outer(body, leaving) + mirrored * self._mirror(how) @ light
        else:
            tile = np.interp(nm, *self.tile)
            scattered = np.array([light[0] * cosine, 0.0, 0.0]) + stray
            stokes = np.outer(tile, scattered)
        after = stokes @ optics.polariser(azimuth, self.leakage).T
        return np.asarray(lamp * (after[:, 0] + self.grating * after[:, 1]))

    def _mirror(self, how: Arrangement) -> Array:
        """Return the Mueller matrix (3, 3) of the facets, 1 for unpolarised light."""
        facet = np.deg2rad(abs(how.illumination + how.viewing)) / 2
        matrix = optics.reflection(facet, self.subject.n)
        return np.asarray(matrix / max(matrix[0, 0], np.finfo(float).tiny))

    def _body(self, light: Array, how: Arrangement) -> Array:
        """Return what light (3,) becomes that enters the skin, scatters and leaves."""
        n = self.subject.n
        s, p = optics.transmission(np.deg2rad(abs(how.illumination)), n)
        entering = light[0] + (s - p) / (s + p) * light[1]
        s, p = optics.transmission(np.deg2rad(how.viewing), n)
        return np.array([entering, (s - p) / (s + p) * entering, 0.0])
