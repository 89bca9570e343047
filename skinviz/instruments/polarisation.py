"""Surface and body of a reflection told apart by polarisers.

Light that the surface mirrors keeps its polarisation; light from the body has lost it,
except that on leaving at a slant more p than s gets out. How much of each goes through
a pair of polarisers is known, so readings in two states say how much there was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.instruments.arrangement import STATES

Array = NDArray[np.float64]

_ALIKE = 0.05  # least difference of two states' weights that still tells them apart


@dataclass(frozen=True)
class Polarisers:
    """What is assumed of skin and polarisers.

    Attributes
    ----------
    n : float
        Refractive index of the skin. [1], 1 to 3
    leakage : float
        What share of the other polarisation a polariser lets through. [1], 0 to 0.2
    asymmetry : float or None
        How much more s than p leaves the body at the viewing angle; from ``n`` if
        None. [1]
    """

    n: float = 1.4
    leakage: float = 0.0
    asymmetry: float | None = None

    def __post_init__(self) -> None:
        """Refuse what no skin and no polariser has."""
        in_range(self.n, 1.0, 3.0, "n")
        in_range(self.leakage, 0.0, 0.2, "leakage")
        if self.asymmetry is not None:
            in_range(self.asymmetry, 0.2, 2.0, "asymmetry")


@dataclass(frozen=True, eq=False)
class Separated:
    """Diffuse and specular part (n,) each, with standard uncertainties. [1]

    ``u_shared`` is what of the specular part's all bands share.
    """

    diffuse: Array
    specular: Array
    u_diffuse: Array
    u_specular: Array
    u_shared: Array


@dataclass(frozen=True)
class Shared:
    """Standard uncertainties that all bands share.

    Attributes
    ----------
    asymmetry : float
        Of the polarisers' asymmetry. [1]
    states : tuple of float
        Of each state's factors, as a share. [1]
    scale : float
        Of all states' factors together, as a share. [1]
    """

    asymmetry: float = 0.0
    states: tuple[float, ...] = ()
    scale: float = 0.0


_NOTHING = Shared()


def fresnel_amplitudes(angle: float, n: float) -> tuple[float, float]:
    """Return the amplitudes of reflection for s and p, alike at normal incidence.

    Parameters
    ----------
    angle : float
        Of incidence. [rad], 0 to π/2
    n : float
        Refractive index. [1], ≥ 1

    Notes
    -----
    r_s = −sin(i − t)/sin(i + t), r_p = −tan(i − t)/tan(i + t), written with cosines;
    the sign of p is that of a picture in a mirror.
    """
    out = np.cos(angle)
    inside = np.sqrt(1 - (np.sin(angle) / n) ** 2)
    s = (out - n * inside) / (out + n * inside)
    p = (inside - n * out) / (inside + n * out)
    return float(s), float(p)


def leaving_asymmetry(viewing: float, n: float) -> float:
    """Return how much more s than p leaves a body at an angle [rad]: (1−F_s)/(1−F_p).

    Examples
    --------
    >>> import numpy as np
    >>> leaving_asymmetry(np.pi / 3, 1.4)
    0.862
    """
    s, p = fresnel_amplitudes(viewing, n)
    return (1 - s * s) / (1 - p * p)


def weights(
    state: str, illumination: float, viewing: float, given: Polarisers
) -> tuple[float, float]:
    """Return by what the diffuse and the specular part enter a state's factor.

    Parameters
    ----------
    state : str
        A key of ``STATES``.
    illumination, viewing : float
        Angles from the normal, illumination negative on the viewer's side. [rad]
    given : Polarisers
        What is assumed of skin and polarisers.

    Returns
    -------
    diffuse, specular : float
        The radiance factor against a depolarising white in the same state is
        diffuse · D + specular · S. [1]

    Notes
    -----
    Each polariser is a mixture of two azimuths: itself and, by its leakage, the one
    across; no polariser is both alike. For a lamp's azimuth χ and an analyser's α from
    the plane of incidence, with F = (r_s² + r_p²)/2 at the facet's angle |i + v|/2,

        S: 2 (sin χ sin α r_s + cos χ cos α r_p)²/F,
        D: 2 (sin² χ T_s + cos² χ T_p)/(T_s + T_p) · 2 (sin² α k + cos² α)/(k + 1),

    T = 1 − r² of the illumination and k the asymmetry of light that leaves.
    """
    lamp, analyser = STATES[one_of(state, STATES, "state of the polarisers")]
    k = given.asymmetry
    if k is None:
        k = leaving_asymmetry(viewing, given.n)
    entering = leaving_asymmetry(abs(illumination), given.n)
    s, p = fresnel_amplitudes(abs(illumination + viewing) / 2, given.n)
    mirror = (s * s + p * p) / 2
    diffuse = specular = 0.0
    for chi, share in _mixture(lamp, given.leakage):
        for alpha, part in _mixture(analyser, given.leakage):
            amplitude = (
                np.sin(chi) * np.sin(alpha) * s + np.cos(chi) * np.cos(alpha) * p
            )
            body = _share(chi, entering) * _share(alpha, k)
            specular += share * part * 2 * amplitude**2 / mirror if mirror else 0.0
            diffuse += share * part * body
    return float(diffuse), float(specular)


def _mixture(azimuth: float | None, leakage: float) -> list[tuple[float, float]]:
    """Return the azimuths [rad] that a polariser mixes, with their shares."""
    along = 0.0 if azimuth is None else np.deg2rad(azimuth)
    other = 0.5 if azimuth is None else leakage
    return [(along, 1 - other), (along + np.pi / 2, other)]


def _share(azimuth: float, ratio: float) -> float:
    """Return light at an azimuth, of s over p in a ratio, over the mean of both."""
    s, p = np.sin(azimuth) ** 2, np.cos(azimuth) ** 2
    return float(2 * (s * ratio + p) / (ratio + 1))


def separate(
    states: Sequence[str],
    factors: Array,
    uncertainties: Array,
    *,
    illumination: float,
    viewing: float,
    given: Polarisers,
    shared: Shared = _NOTHING,
) -> Separated:
    """Return the diffuse and the specular part of factors in two or more states.

    Parameters
    ----------
    states : sequence of str, m
        Keys of ``STATES``.
    factors, uncertainties : (m, n) ndarray
        Radiance factors against the white in the same state, with their standard
        uncertainties; NaN where not measured. [1]
    illumination, viewing : float
        As for :func:`weights`. [rad]
    given : Polarisers
        What is assumed.
    shared : Shared
        What of the uncertainties all bands share. That of states and of scale is
        among ``uncertainties`` already, that of the asymmetry is not.

    Returns
    -------
    separated : Separated
        As radiance factors, the white lit as the skin is.

    Raises
    ------
    ArgumentError
        If the states do not tell surface and body apart at these angles.

    Notes
    -----
    Least squares in each band, which is exact for two states. The paper's difference of
    two readings takes k = 1 and the mirror for a perfect polariser: at 60° that is
    wrong by 7 to 11 % of the diffuse part (n = 1.4 to 1.55).
    """

    def solved(values: Array, assumed: Polarisers) -> Separated:
        return _solve(states, values, uncertainties, (illumination, viewing), assumed)

    found = solved(factors, given)
    k = given.asymmetry
    if k is None:
        k = leaving_asymmetry(viewing, given.n)
    turned = solved(factors, replace(given, asymmetry=k + shared.asymmetry))
    moved = [turned.specular - found.specular, shared.scale * found.specular]
    for i, share in enumerate(shared.states):
        scaled = factors.copy()
        scaled[i] *= 1 + share
        moved.append(solved(scaled, given).specular - found.specular)
    return Separated(
        found.diffuse,
        found.specular,
        np.hypot(found.u_diffuse, turned.diffuse - found.diffuse),
        np.hypot(found.u_specular, moved[0]),
        np.sqrt(np.square(moved).sum(axis=0)),
    )


def state_weights(
    states: Sequence[str], angles: tuple[float, float], given: Polarisers
) -> Array:
    """Return the weights (m, 2) of states at angles of illumination and viewing [rad].

    Raises
    ------
    ArgumentError
        If they do not tell surface and body apart.
    """
    rows = np.array([weights(state, *angles, given) for state in states])
    if len(rows) < 2 or np.ptp(rows[:, 1] - rows[:, 0]) < _ALIKE:
        illumination, viewing = np.rad2deg(angles)
        raise ArgumentError(
            f"the states {', '.join(states)} do not tell surface and body apart at "
            f"{illumination:g}/{viewing:g} degrees; measure s and p near Brewster's "
            "angle, parallel and crossed near the normal"
        )
    return rows


def _solve(
    states: Sequence[str],
    factors: Array,
    uncertainties: Array,
    angles: tuple[float, float],
    given: Polarisers,
) -> Separated:
    """Return weighted least squares of two unknowns in each band."""
    d, s = state_weights(states, angles, given).T[..., np.newaxis]
    w = 1 / np.square(uncertainties)
    dd, ds, ss = ((w * x).sum(axis=0) for x in (d * d, d * s, s * s))
    df, sf = ((w * x * factors).sum(axis=0) for x in (d, s))
    det = dd * ss - ds * ds
    return Separated(
        (ss * df - ds * sf) / det,
        (dd * sf - ds * df) / det,
        np.sqrt(ss / det),
        np.sqrt(dd / det),
        np.zeros(det.shape),
    )
