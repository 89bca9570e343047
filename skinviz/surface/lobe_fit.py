"""The lobe of Torrance–Sparrow's model from goniometer data, as the paper found it.

The paper fixes the viewing angle near 60°, turns the light, and extracts the specular
part with a polariser. What does not belong here: readings and their files
(``surface.gonio``), the function that is fitted (``surface.lobe_curve``), the search
for its minimum (``surface.lobe_solver``) and what follows (``surface.fitted_lobe``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.surface.fitted_lobe import LobeFit, covariance_and_interval
from skinviz.surface.gonio import as_readings, as_uncertainty, per_reading
from skinviz.surface.lobe_curve import BOUNDS, PARAMETERS, LobeCurve, masked_spread
from skinviz.surface.lobe_solver import solve
from skinviz.surface.torrance_sparrow import MASKINGS

Array = NDArray[np.float64]

DIFFUSERS = ("facing", "alike")
"""How the perfect diffuser that is the unit was lit: ``"facing"`` the light, E of
eq. (10), or ``"alike"`` as the skin was, at the same angle: the radiance factor."""


def fit_lobe(
    illumination: ArrayLike,
    specular: ArrayLike,
    *,
    viewing: ArrayLike = np.pi / 3,
    free: Sequence[str] = ("beta", "gamma"),
    beta: float | None = None,
    gamma: float | None = None,
    n: float = 1.4,
    uncertainty: ArrayLike | None = None,
    masking: str = "v-cavity",
    diffuser: str = "facing",
) -> LobeFit:
    """Estimate Torrance–Sparrow's β and γ from the specular part by angle.

    Parameters
    ----------
    illumination : (m,) array_like
        Angles of the light from the normal; the paper's are 0–85°. [rad], 0 to π/2
    specular : (m,) array_like
        Specular part of the reflection, by a polariser, in units of the perfect
        diffuser; noise may make some negative. [1]
    viewing : float or (m,) array_like
        Angles of the viewer, opposite the light. [rad], 0 to π/2
    free : sequence of str
        Which of "beta", "gamma" and "n" are estimated.
    beta, gamma, n : float
        Values of those that are not.
    uncertainty : float or (m,) array_like, optional
        Standard deviation of each reading. The fit is then weighted and its
        covariance absolute; without it the residual scales the covariance. [1], > 0
    masking : {"v-cavity", "none"}
        As in :class:`TorranceSparrow`.
    diffuser : {"facing", "alike"}
        How the perfect diffuser was lit: facing the light, or as the skin was.

    Returns
    -------
    fit : LobeFit
        The estimates, their covariance and status; ``fit.surface`` is the surface.

    Raises
    ------
    ArgumentError
        If the data are empty, not finite, of unlike length, at angles that are none,
        nowhere above 0 or too few for what is free.

    Notes
    -----
    Least squares within ``BOUNDS``, from the best of many starts. In the plane of
    incidence the facet's angle is φ = |θ_i − θ_v|/2 and V·H = cos((θ_i + θ_v)/2).
    β and n are nearly the same to the data (correlation −0.94 on the paper's angles,
    noise alike at all): to free n makes β three times less certain.

    Examples
    --------
    >>> import numpy as np
    >>> angles = np.deg2rad(np.arange(0, 86, 5))
    >>> from skinviz import TorranceSparrow
    >>> from skinviz.surface.lobe_curve import in_plane
    >>> truth = TorranceSparrow.from_beta(1.2, 0.3)
    >>> fit_lobe(angles, in_plane(truth, angles)).values.round(6).tolist()
    [1.2, 0.3]
    """
    one_of(masking, MASKINGS, "masking")
    names = _free(free)
    fixed = _fixed(names, {"beta": beta, "gamma": gamma, "n": n})
    light, view, data = as_readings(illumination, viewing, specular)
    sigma = as_uncertainty(uncertainty, data.size)
    _require_enough(data, names, absolute=sigma is not None)
    curve = LobeCurve(
        names,
        fixed,
        turn=np.abs(light - view) / 2,
        cosine=np.cos((light + view) / 2),
        spread=masked_spread(light, view, masking) / _unit(light, diffuser),
    )
    values, held, status = solve(
        curve, data, np.ones(data.size) if sigma is None else sigma
    )
    fitted = curve(values)
    covariance, interval = covariance_and_interval(
        curve.slopes(values), fitted - data, sigma, values, held, curve.bounds
    )
    found_beta, found_gamma, found_n = map(float, curve.every(values))
    return LobeFit(
        parameters=names,
        values=values,
        covariance=covariance,
        interval=interval,
        status=status,
        beta=found_beta,
        gamma=found_gamma,
        n=found_n,
        masking=masking,
        illumination=light,
        viewing=view,
        specular=data,
        uncertainty=sigma,
        fitted=fitted,
    )


def alpha_from_diffuse(
    illumination: ArrayLike,
    diffuse: ArrayLike,
    reflectance: ArrayLike,
    *,
    diffuser: str = "facing",
) -> float:
    """Return α of eq. (10), the diffuse weight, from what the polariser left. [1]

    Parameters
    ----------
    illumination : (m,) array_like
        Angles of the light from the normal. [rad], 0 to π/2
    diffuse : (m,) array_like
        Diffuse part of the reflection, in units of the perfect diffuser. [1]
    reflectance : float or (m,) array_like
        R_b, the body's reflectance in the band of the readings. [1], ≥ 0
    diffuser : {"facing", "alike"}
        As in :func:`fit_lobe`.

    Raises
    ------
    ArgumentError
        If the data are empty, not finite or of unlike length, or a body that is black
        at every angle says nothing of α.

    Notes
    -----
    Linear least squares of α (N·L) R_b; it may turn out negative where noise is all.
    """
    light, _, data = as_readings(illumination, 0.0, diffuse)
    body = per_reading(reflectance, data.size, "reflectance")
    if (body < 0).any():
        raise ArgumentError(f"reflectance must be at least 0; got {body.min():g}")
    shape = body * np.cos(light) / _unit(light, diffuser)
    if not (shape > 0).any():
        raise ArgumentError("a body that reflects nothing says nothing of alpha")
    return float(shape @ data / (shape @ shape))


def _unit(light: Array, diffuser: str) -> Array:
    """Return the perfect diffuser's radiance (m,) over that of one facing the light."""
    alike = one_of(diffuser, DIFFUSERS, "diffuser") == "alike"
    return np.cos(light) if alike else np.ones(light.size)


def _free(free: Sequence[str]) -> tuple[str, ...]:
    """Return what is free in the order of ``PARAMETERS``."""
    asked = (free,) if isinstance(free, str) else tuple(free)
    for name in asked:
        one_of(name, PARAMETERS, "free parameter")
    if not asked:
        raise ArgumentError(f"nothing is free; name some of {', '.join(PARAMETERS)}")
    return tuple(name for name in PARAMETERS if name in asked)


def _fixed(free: tuple[str, ...], given: dict[str, float | None]) -> dict[str, float]:
    """Return the values of what is not free, checked."""
    fixed = {}
    for name in PARAMETERS:
        value = given[name]
        if name in free:
            if value is not None and name != "n":
                raise ArgumentError(f"{name} is free; give no value of it, or fix it")
        elif value is None:
            raise ArgumentError(f"{name} is neither free nor given; pass {name}=")
        else:
            fixed[name] = in_range(value, *BOUNDS[name], name)
    return fixed


def _require_enough(data: Array, names: tuple[str, ...], *, absolute: bool) -> None:
    """Refuse readings without light, and fewer than the parameters need."""
    needed = len(names) + (not absolute)
    if data.size < needed:
        raise ArgumentError(
            f"{data.size} readings are too few for {', '.join(names)}; at least "
            f"{needed} are needed"
            + ("" if absolute else f", or {len(names)} with uncertainty=")
        )
    if not (data > 0).any():
        raise ArgumentError(
            "no reading is above 0, so there is no specular reflection to fit; the "
            f"largest is {data.max():g}"
        )
