"""The specular part by angle, averaged over bands, for the fit of a lobe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skinviz.errors import SkinvizError
from skinviz.instruments.arrangement import STATES
from skinviz.instruments.derive import Derived, weighted_mean
from skinviz.instruments.factor import Array
from skinviz.instruments.polarisation import Separated

_BAND = (400.0, 700.0)  # nm, over which the lobe is averaged


@dataclass(frozen=True, eq=False)
class Lobe:
    """The specular part by angle, as :func:`skinviz.fit_lobe` takes it.

    Attributes
    ----------
    illumination, viewing : (m,) ndarray
        [degrees]
    specular, uncertainty : (m,) ndarray
        Averaged over 400–700 nm, in units of the perfect diffuser that faces the
        lamp. [1]
    """

    illumination: Array
    viewing: Array
    specular: Array
    uncertainty: Array


def lobe_of(derived: Derived, site: str) -> Lobe:
    """Return the specular part of a site by angle.

    The white is lit as the skin is; the unit of the lobe's fit is a diffuser that
    faces the lamp, so factors are multiplied by the cosine of the illumination.

    Raises
    ------
    SkinvizError
        If no states were measured that tell surface and body apart, or nothing is
        known of 400–700 nm.
    """
    plan, nm = derived.frames.plan, derived.frames.wavelengths
    inside = (nm >= _BAND[0]) & (nm <= _BAND[1])
    rows = []
    for illumination in sorted(plan.illumination):
        part = derived.parts.get((site, illumination))
        if part is None or illumination < 0:
            continue
        if not np.isfinite(part.u_specular[inside]).any():
            raise SkinvizError(
                f"no band of {_BAND[0]:g}-{_BAND[1]:g} nm is known at {illumination:g} "
                "degrees; the lobe needs a white's certificate and light there"
            )
        cosine = np.cos(np.deg2rad(illumination))
        value, _ = weighted_mean(part.specular[inside], part.u_specular[inside])
        rows.append(
            (illumination, value * cosine, _uweighted_mean(part, inside) * cosine)
        )
    if not rows:
        raise SkinvizError(
            "there is no specular part in this log; plan states = "
            f'["s", "p"] or another pair of {", ".join(STATES)}'
        )
    angles, specular, u = np.array(rows).T
    return Lobe(angles, np.full(angles.size, plan.viewing), specular, u)


def _uweighted_mean(part: Separated, inside: np.ndarray) -> float:
    """Return the uncertainty of the mean of the specular part over bands.

    Noise is independent from band to band; what bands share, the asymmetry and the
    white's certificate, does not average out, and is taken from their own share.
    """
    known = inside & np.isfinite(part.u_specular)
    shared = part.u_shared[known]
    alone = np.sqrt(np.maximum(part.u_specular[known] ** 2 - shared**2, 1e-30))
    weight = 1 / np.square(part.u_specular[known])
    weight = weight / weight.sum()
    return float(np.hypot(np.sqrt(weight**2 @ alone**2), weight @ shared))
