"""What measured reflectance can be: refused here before it reaches a fit.

What does not belong here: mending. Nothing is clipped, sorted or filled.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import DataError, SkinvizError

_HIGHEST = 1.5  # above this it is no reflectance, however glossy
_VISIBLE = (400.0, 700.0)  # nm; beyond, instruments are noisy and nothing uses it
_BLOCK = 2**20  # values judged at once, which bounds the memory


@dataclass(frozen=True)
class Judged:
    """Where spectra are from and how they are written, for the messages.

    Attributes
    ----------
    where : str
        The file's name.
    full : float
        What reflectance 1 is written as.
    told : bool
        Whether the file itself says so.
    missing : bool
        Whether NaN marks a missing band here.
    error : type
        What is raised.
    """

    where: str
    full: float = 1.0
    told: bool = False
    missing: bool = False
    error: type[SkinvizError] = DataError


def require_wavelengths(wavelengths: NDArray[np.float64], by: Judged) -> None:
    """Refuse wavelengths that do not ascend or are not in nm."""
    if not np.isfinite(wavelengths).all():
        raise by.error(f"{by.where}: a wavelength is not a finite number")
    steps = np.flatnonzero(np.diff(wavelengths) <= 0)
    if steps.size:
        i = int(steps[0])
        raise by.error(
            f"{by.where}: wavelengths must ascend; {wavelengths[i + 1]:g} nm follows "
            f"{wavelengths[i]:g} nm; reverse or sort them with their values"
        )
    if wavelengths[0] < 100 or wavelengths[-1] > 5000:
        raise by.error(
            f"{by.where}: wavelengths run from {wavelengths[0]:g} to "
            f"{wavelengths[-1]:g}; they are expected in nm"
        )


def require_list(
    values: NDArray[Any],
    wavelengths: NDArray[np.float64],
    labels: list[str],
    by: Judged,
) -> None:
    """Refuse a list (record, n) of which a value in the visible is no reflectance."""
    inside = _inside(wavelengths)
    wavelengths, values = wavelengths[inside], values[:, inside]
    unfit = np.isinf(values) if by.missing else ~np.isfinite(values)
    checks = (
        (unfit, "is not finite; remove the band or the spectrum"),
        (values < 0, "is negative; check the dark and white measurements"),
        (values > _HIGHEST * by.full, f"is above {_too_high(by)}"),
    )
    for bad, why in checks:
        if bad.any():
            record, band = (int(i) for i in np.argwhere(bad)[0])
            raise by.error(
                f"{by.where}, spectrum {labels[record]!r} at {wavelengths[band]:g} nm: "
                f"{values[record, band]:g} {why}"
            )
    _require_not_fractions(_largest(values), by)


def require_cube(
    values: NDArray[Any], wavelengths: NDArray[np.float64], by: Judged
) -> None:
    """Refuse a cube (line, sample, n) whose scale is wrong or which has infinities.

    Single pixels below 0 or above 1.5 are noise and highlights: they stay, and a
    fit refuses them one by one.
    """
    inside = _inside(wavelengths)
    step = max(1, _BLOCK // (values.shape[1] * values.shape[2]))
    high = counted = 0
    largest = -np.inf
    for i in range(0, values.shape[0], step):
        part = values[i : i + step][..., inside]
        if np.isinf(part).any():
            line, sample, _ = (int(n) for n in np.argwhere(np.isinf(part))[0])
            raise by.error(
                f"{by.where}: the value at line {line + i}, sample {sample} is "
                "infinite; mark missing values as NaN"
            )
        high += int((part > _HIGHEST * by.full).sum())
        counted += int((~np.isnan(part)).sum())
        largest = max(largest, _largest(part))
    if 2 * high > counted:
        raise by.error(
            f"{by.where}: {high} of {counted} values are above {_too_high(by)}"
        )
    _require_not_fractions(largest, by)


def _largest(values: NDArray[Any]) -> float:
    """Return the largest value that is a number, -inf if none is.

    ``numpy.nanmax`` takes the NaNs that signal, which broken files hold, for numbers
    on some processors.
    """
    return float(np.max(values, where=~np.isnan(values), initial=-np.inf))


def _inside(wavelengths: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which bands are judged."""
    return np.asarray((wavelengths >= _VISIBLE[0]) & (wavelengths <= _VISIBLE[1]))


def _too_high(by: Judged) -> str:
    """Return the highest value and what to do about higher ones."""
    if by.full != 1:
        return f"{_HIGHEST * by.full:g}{' %' if by.full == 100 else ''}"
    if by.told:
        return f"{_HIGHEST}, and the file declares 0 to 1; correct its scale"
    if by.error is DataError:
        return f"{_HIGHEST}; if the file is in per cent say --scale percent"
    return f"{_HIGHEST}; reflectance is written as 0 to 1"


def _require_not_fractions(largest: float, by: Judged) -> None:
    """Refuse 0–1 where more stands for reflectance 1."""
    if by.full > 1 and -np.inf < largest <= 1:
        what = "in per cent" if by.full == 100 else f"where {by.full:g} stands for 1"
        do = "correct the scale in the file" if by.told else "say --scale fraction"
        raise by.error(
            f"{by.where}: every value is at most 1, which is no skin {what}; {do}"
        )
