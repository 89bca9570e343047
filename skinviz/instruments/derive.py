"""What follows from a session's readings: radiance factors, and reflectance."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from skinviz.errors import DataError
from skinviz.instruments.arrangement import SAMPLE, Arrangement
from skinviz.instruments.certificate import Certificate
from skinviz.instruments.errors import InstrumentError
from skinviz.instruments.factor import (
    NOTABLE_DRIFT,
    Array,
    Factor,
    radiance_factor,
)
from skinviz.instruments.frames import Frames, White, frames_of
from skinviz.instruments.plan import BEFORE, Plan
from skinviz.instruments.polarisation import Separated, Shared, separate
from skinviz.instruments.skinlog import SkinLog, read_log

if TYPE_CHECKING:
    import xarray

_FREE_OF_GLOSS = 40.0  # degrees; no facet is tilted so far that it would mirror


@dataclass(frozen=True, eq=False)
class Derived:
    """All that a session says of the skin.

    Attributes
    ----------
    frames : Frames
        The means that it follows from.
    factors : dict of (site, illumination, state) to Factor
        Radiance factors; illumination in degrees.
    parts : dict of (site, illumination) to Separated
        Body and surface, where the states tell them apart.
    scale : float
        Standard uncertainty of the white's certificate, the share that all bands have
        in common. [1]
    asymmetry : dict of site to (float, float)
        Of the light that leaves the body, measured, with its standard uncertainty.
    notes : tuple of str
        What is worth to know, as a drift of the white.
    """

    frames: Frames
    factors: dict[tuple[str, float, str], Factor]
    parts: dict[tuple[str, float], Separated]
    scale: float
    asymmetry: dict[str, tuple[float, float]]
    notes: tuple[str, ...]


def derive(log: SkinLog) -> Derived:
    """Return what follows from a session that is finished.

    Raises
    ------
    WhiteMissing, DriftExceeded
        If the white is missing before or after, or changed too much.
    DataError
        If something of the plan was not measured, or the white is known in no band.
    """
    frames = frames_of(log)
    certificate = Certificate.from_json(log.header["certificate"])
    certified, u_certified = certificate.at(frames.wavelengths)
    if not np.isfinite(certified).any():
        raise DataError(
            "no band of the readings is in the white's certificate; measure with the "
            "certificate of the tile"
        )
    plan = frames.plan
    factors: dict[tuple[str, float, str], Factor] = {}
    bends: dict[tuple[str, float, str], float] = {}
    drifts = [0.0]
    for site in plan.sites:
        for illumination in plan.illumination:
            for state in plan.states:
                how = Arrangement(SAMPLE, True, illumination, plan.viewing, state)
                found, white = _against_white(frames, site, how, certificate)
                factors[site, illumination, state] = found
                drifts.append(white.drift)
                bends[site, illumination, state] = white.bend
    notes = []
    most = max(drifts, key=abs)
    if abs(most) > NOTABLE_DRIFT:
        notes.append(f"the white changed by up to {most:+.2%}, which is corrected")
    if not np.isfinite(certified).all():
        notes.append("bands outside the white's certificate are left out")
    scale = float(np.nanmedian(u_certified / certified))
    parts, asymmetry = _parts(frames, factors, bends, scale)
    return Derived(frames, factors, parts, scale, asymmetry, tuple(notes))


def _against_white(
    frames: Frames, site: str, how: Arrangement, certificate: Certificate
) -> tuple[Factor, White]:
    """Return a site's radiance factor in an arrangement, and its white."""
    sample = frames.sample(site, how)
    white = frames.white(how, sample.time)
    found = radiance_factor(
        sample,
        white.frame,
        *certificate.at(frames.wavelengths),
        ambient_sample=frames.ambient(site, how.state),
        ambient_white=frames.ambient(BEFORE, how.state),
    )
    if not np.isfinite(found.value).any():
        raise DataError(
            f"the white at {how.illumination:g}/{how.viewing:g} degrees, polarisers "
            f"{how.state}, is above the stray light in no band of its certificate; "
            "measure again, with the lamp shuttered for stray light only"
        )
    return found, white


def _parts(
    frames: Frames,
    factors: dict[tuple[str, float, str], Factor],
    bends: dict[tuple[str, float, str], float],
    scale: float,
) -> tuple[dict[tuple[str, float], Separated], dict[str, tuple[float, float]]]:
    """Return body and surface, and the asymmetries that they were told apart with."""
    plan = frames.plan
    parts: dict[tuple[str, float], Separated] = {}
    measured = {}
    if len(plan.states) < 2:
        return parts, {}
    for site in plan.sites:
        given, u = plan.polarisers, 0.0
        found = _asymmetry(plan, site, factors, bends)
        if found is not None:
            measured[site] = found
            given, u = replace(given, asymmetry=found[0]), found[1]
        for illumination in plan.illumination:
            own = [factors[site, illumination, state] for state in plan.states]
            parts[site, illumination] = separate(
                plan.states,
                np.array([factor.value for factor in own]),
                np.array([factor.u for factor in own]),
                illumination=np.deg2rad(illumination),
                viewing=np.deg2rad(plan.viewing),
                given=given,
                shared=Shared(
                    asymmetry=u,
                    states=tuple(bends[site, illumination, s] for s in plan.states),
                    scale=scale,
                ),
            )
    return parts, measured


def _asymmetry(
    plan: Plan,
    site: str,
    factors: dict[tuple[str, float, str], Factor],
    bends: dict[tuple[str, float, str], float],
) -> tuple[float, float] | None:
    """Return s over p where there is no gloss, and its uncertainty, if measured."""
    free = [a for a in plan.illumination if (plan.viewing - a) / 2 >= _FREE_OF_GLOSS]
    pairs = [
        (factors[site, a, "s"], factors[site, a, "p"])
        for a in free
        if (site, a, "s") in factors and (site, a, "p") in factors
    ]
    if not pairs:
        return None
    ratios = np.array([s.value / p.value for s, p in pairs])
    spread = np.array([np.hypot(s.u / s.value, p.u / p.value) for s, p in pairs])
    leak = plan.leakage
    true = (ratios * (1 - leak) - leak) / (1 - leak - ratios * leak)
    mean, u = weighted_mean(true, spread * true)
    bent = max(np.hypot(bends[site, a, "s"], bends[site, a, "p"]) for a in free)
    return mean, float(np.hypot(u, mean * bent))


def weighted_mean(values: Array, u: Array) -> tuple[float, float]:
    """Return the mean of values weighted by their uncertainties, and its own."""
    known = np.isfinite(values) & np.isfinite(u)
    weight = 1 / np.square(u[known])
    return float(weight @ values[known] / weight.sum()), float(weight.sum() ** -0.5)


def read_session(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read the reflectance that a session's log leads to.

    Parameters
    ----------
    path : path-like
        A ``.skinlog`` of a session that is finished.

    Returns
    -------
    spectra : xarray.Dataset
        As :func:`skinviz.read_spectra` returns: ``reflectance`` (record, wavelength),
        with ``uncertainty``, its standard uncertainty, beside it [1], NaN in bands that
        say nothing. A record for each site and angle: the body's part where polarisers
        tell it apart, the radiance factor otherwise; angles on the viewer's side are
        left out. ``subject`` and ``site`` are coordinates. The attribute
        ``scale_uncertainty`` is the share of the uncertainty that all bands have in
        common, by the white's certificate. [1]

    Raises
    ------
    DataError, InstrumentError
        As for :func:`derive`.
    """
    log = read_log(path)
    try:
        return spectra_of(log, derive(log), os.fspath(path))
    except InstrumentError as error:
        raise type(error)(f"{os.fspath(path)}: {error}") from error


def spectra_of(log: SkinLog, derived: Derived, source: str) -> xarray.Dataset:
    """Return the reflectance of a session as :func:`read_session` does."""
    import xarray

    plan = derived.frames.plan
    told = [a for a in plan.illumination if a >= 0] or list(plan.illumination)
    keys = [(site, angle) for site in plan.sites for angle in told]
    values, u = zip(*(_body(derived, *key) for key in keys), strict=True)
    several = len(told) > 1
    labels = [
        f"{site} {angle:g}/{plan.viewing:g}" if several else site
        for site, angle in keys
    ]
    meter = log.header["meter"]
    return xarray.Dataset(
        {
            "reflectance": (("record", "wavelength"), np.array(values), {"units": "1"}),
            "uncertainty": (("record", "wavelength"), np.array(u), {"units": "1"}),
        },
        coords={
            "wavelength": ("wavelength", derived.frames.wavelengths, {"units": "nm"}),
            "record": np.arange(len(keys)),
            "label": ("record", np.array(labels)),
            "site": ("record", np.array([site for site, _ in keys])),
            "subject": ("record", np.full(len(keys), plan.subject)),
        },
        attrs={
            "source": source,
            "specular": "excluded",
            "scale_uncertainty": derived.scale,
            "geometry": _geometry(told, plan.viewing),
            "instrument": f"{meter['maker']} {meter['model']} {meter['serial']}",
            "date": str(log.header["utc"])[:19],
        },
    )


def _body(derived: Derived, site: str, illumination: float) -> tuple[Array, Array]:
    """Return the body's part, or the radiance factor where only that is known."""
    part = derived.parts.get((site, illumination))
    if part is not None:
        return part.diffuse, part.u_diffuse
    (state, *_) = derived.frames.plan.states
    factor = derived.factors[site, illumination, state]
    return factor.value, factor.u


def _geometry(angles: list[float], viewing: float) -> str:
    """Return the standard's code of a geometry, or its angles."""
    if angles == [45.0] and viewing == 0:
        return "45x:0"
    return f"{', '.join(f'{a:g}' for a in angles)}:{viewing:g}"
