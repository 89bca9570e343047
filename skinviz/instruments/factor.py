"""The radiance factor against a white, and how sure it is: pure functions of arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers
from skinviz.errors import ArgumentError
from skinviz.instruments.errors import DriftExceeded

Array = NDArray[np.float64]

NOTABLE_DRIFT, LARGEST_DRIFT = 0.005, 0.02
"""Change of the white between two readings that is told, and that is refused. [1]"""

STEADY = 0.002
"""Within which three readings of the white agree when the lamp has settled. [1]"""

_IN_A_ROW = 3
_BENT = 1 / 8  # of the change, by which the light may be off a line half-way
_POOLED = 8  # bands on each side whose scatter is taken together
_OVER_DARK = 10.0  # times its uncertainty that a signal must be over the stray light


@dataclass(frozen=True, eq=False)
class Frame:
    """The mean of some readings of one thing.

    Attributes
    ----------
    mean, u, dof : (n,) ndarray
        Mean, its standard uncertainty, in one unit, and its degrees of freedom.
    scatter : float
        Standard deviation of the readings' sums over all bands, relatively. [1]
    time : float
        Their mean. [s]
    """

    mean: Array
    u: Array
    dof: Array
    scatter: float
    time: float


@dataclass(frozen=True, eq=False)
class Factor:
    """A radiance factor (n,), its standard uncertainty and degrees of freedom.

    NaN where the white is not well above the stray light, or the certificate ends.
    """

    value: Array
    u: Array
    dof: Array


def frame_of(values: ArrayLike, times: ArrayLike) -> Frame:
    """Return the mean of repeated readings.

    Parameters
    ----------
    values : (N, n) array_like
        At least two readings.
    times : (N,) array_like
        [s]

    Raises
    ------
    ArgumentError
        If there are fewer than two, or they are not finite.

    Notes
    -----
    The variance of five readings is itself known to 70 % only, and weights made of it
    would pretend to more than there is. Noise is alike in bands side by side, as a
    multiple of their signal, so its variance is pooled over ±8 bands.
    """
    data, at = as_numbers(values, "readings"), as_numbers(times, "times")
    if data.ndim != 2 or len(data) < 2 or at.shape != data.shape[:1]:
        raise ArgumentError(
            f"a mean needs readings (N, n) with N times, N at least 2; got shapes "
            f"{data.shape} and {at.shape}"
        )
    if not np.isfinite(data).all():
        raise ArgumentError("readings must be finite; leave out those that are not")
    repeats, count = data.shape
    mean = data.mean(axis=0)
    size = np.abs(mean) + 1e-3 * np.abs(mean).max() + np.finfo(float).tiny
    window = np.ones(2 * _POOLED + 1)
    bands = np.convolve(np.ones(count), window)[_POOLED : _POOLED + count]
    relative = data.var(axis=0, ddof=1) / size
    pooled = np.convolve(relative, window)[_POOLED : _POOLED + count] / bands
    sums = data.sum(axis=1)
    total = abs(sums.mean())
    return Frame(
        mean,
        np.sqrt(pooled * size / repeats),
        (repeats - 1) * bands,
        float(sums.std(ddof=1) / total) if total else 0.0,
        float(at.mean()),
    )


def between(before: Frame, after: Frame, time: float) -> Frame:
    """Return what a frame was at a time between two readings of it, on a line.

    A lamp need not change along a line. If it changed three times as fast at one end as
    at the other, it was an eighth of the change off the line half-way. So far it may
    be, all alike: a rectangular distribution, narrower towards both readings, and
    the same share in all bands.
    """
    late = place(before, after, time)
    mean = (1 - late) * before.mean + late * after.mean
    bent = bend(before, after, time) * np.abs(mean)
    parts = np.array([(1 - late) * before.u, late * after.u, bent])
    known = np.array([before.dof, after.dof, np.full(mean.size, np.inf)])
    return Frame(
        mean,
        np.sqrt(np.square(parts).sum(axis=0)),
        effective_dof(parts, known),
        max(before.scatter, after.scatter),
        time,
    )


def place(before: Frame, after: Frame, time: float) -> float:
    """Return where a time is between two frames: 0 at the first, 1 at the second."""
    span = after.time - before.time
    return 0.5 if span == 0 else (time - before.time) / span


def bend(before: Frame, after: Frame, time: float) -> float:
    """Return the standard uncertainty of a line between frames, as a share. [1]"""
    late = place(before, after, time)
    change = abs(after.mean.sum() / before.mean.sum() - 1)
    return float(_BENT * 4 * late * (1 - late) * change / np.sqrt(3))


def effective_dof(parts: Array, dof: Array) -> Array:
    """Return Welch and Satterthwaite's degrees of freedom of a sum (n,).

    Parameters
    ----------
    parts, dof : (m, n) ndarray
        Standard uncertainties and degrees of freedom of what is added.
    """
    total = np.square(parts).sum(axis=0)
    share = np.divide(
        np.square(parts), total, out=np.ones(parts.shape), where=total > 0
    )
    lost = (np.square(share) / dof).sum(axis=0)
    known = np.full(lost.shape, np.inf)
    return np.asarray(np.divide(1.0, lost, out=known, where=lost > 0))


def drift(before: Frame, after: Frame) -> float:
    """Return by what share the light changed between two readings of the white.

    Raises
    ------
    DriftExceeded
        If by more than ``LARGEST_DRIFT``.
    """
    change = float(after.mean.sum() / before.mean.sum()) - 1
    if not abs(change) <= LARGEST_DRIFT:
        raise DriftExceeded(
            f"the white changed by {change:+.1%} between its two readings, more than "
            f"{LARGEST_DRIFT:.0%}; let the lamp settle, check that the tile lies as "
            "before, and measure again"
        )
    return change


def is_steady(sums: ArrayLike) -> bool:
    """Return whether the last three of some readings' sums agree."""
    last = as_numbers(sums, "sums").ravel()[-_IN_A_ROW:]
    return bool(
        last.size == _IN_A_ROW
        and (last > 0).all()
        and np.ptp(last) <= STEADY * last.mean()
    )


def less(light: Frame, dark: Frame | None) -> Frame:
    """Return a frame without the stray light."""
    if dark is None:
        return light
    parts = np.array([light.u, dark.u])
    return Frame(
        light.mean - dark.mean,
        np.sqrt(np.square(parts).sum(axis=0)),
        effective_dof(parts, np.array([light.dof, dark.dof])),
        light.scatter,
        light.time,
    )


def radiance_factor(
    sample: Frame,
    white: Frame,
    certified: Array,
    u_certified: Array,
    *,
    ambient_sample: Frame | None = None,
    ambient_white: Frame | None = None,
) -> Factor:
    """Return the radiance factor of a sample, the white lit and seen alike.

    Parameters
    ----------
    sample, white : Frame
        Readings with the lamp on; the white's at the sample's time.
    certified, u_certified : (n,) ndarray
        The white's own radiance factor with its standard uncertainty; NaN outside the
        certificate. [1]
    ambient_sample, ambient_white : Frame, optional
        The same with the lamp shuttered: stray light, which sample and white reflect
        each in its own way.

    Returns
    -------
    factor : Factor

    Notes
    -----
    R = ρ_w (S − A_s)/(W − A_w), and with S′, W′ for the differences

        u²(R) = (ρ_w/W′)² (u²(S′) + (S′/W′)² u²(W′)) + (S′/W′)² u²(ρ_w).

    The meters subtract their detectors' own dark signal themselves.
    """
    S, W = less(sample, ambient_sample), less(white, ambient_white)  # noqa: N806
    floor = 0.0 if ambient_white is None else _OVER_DARK * ambient_white.u
    seen = (W.mean > np.maximum(floor, 0.0)) & np.isfinite(certified)
    light = np.where(seen, W.mean, np.nan)
    ratio = S.mean / light
    parts = np.array(
        [
            certified / light * S.u,
            certified / light * np.abs(ratio) * W.u,
            np.abs(ratio) * u_certified,
        ]
    )
    dof = np.array([S.dof, W.dof, np.full(light.size, np.inf)])
    return Factor(
        certified * ratio,
        np.sqrt(np.square(parts).sum(axis=0)),
        np.where(seen, effective_dof(parts, dof), np.nan),
    )
