"""Colour differences between pictures, and the time to an equal one."""

from dataclasses import dataclass

import numpy as np

from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab


@dataclass(frozen=True)
class Difference:
    """ΔE00 over the pixels compared: mean, 99th percentile, largest."""

    mean: float
    high: float
    largest: float

    def __str__(self) -> str:
        """Return the three with enough digits to be told apart."""
        return f"{self.mean:.3f} / {self.high:.3f} / {self.largest:.2f}"


@dataclass(frozen=True)
class Point:
    """One way of making the picture: samples a pixel, its time [s] and its error."""

    samples: int
    seconds: float
    error: Difference
    noise: float = 0.0


def difference(map_: np.ndarray) -> Difference:
    """Return the summary of a map's pixels, those outside (NaN) apart."""
    values = map_[np.isfinite(map_)]
    return Difference(
        float(values.mean()), float(np.percentile(values, 99)), float(values.max())
    )


def colour_map(xyz, other, white, inside) -> np.ndarray:
    """Return ΔE00 (height, width), NaN outside."""
    map_ = np.full(inside.shape, np.nan)
    labs = (xyz_to_lab(x[inside], white) for x in (xyz, other))
    map_[inside] = delta_e_2000(*labs)
    return map_


def seconds_to(error: float, points: list[Point], part: str) -> tuple[float, str]:
    """Return the time of an error, and how it is known: "", "> " or "< ".

    Between two of the points time is a power of the error. ``part``: "mean", "high".
    """
    times = np.log([p.seconds for p in points])
    errors = np.log([getattr(p.error, part) for p in points])
    if np.log(error) < errors.min():
        return float(np.exp(times[np.argmin(errors)])), "> "
    if np.log(error) > errors.max():
        return float(np.exp(times[np.argmax(errors)])), "< "
    order = np.argsort(errors)
    return float(np.exp(np.interp(np.log(error), errors[order], times[order]))), ""
