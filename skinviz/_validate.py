"""Checks that public functions run on their arguments, once, at the entry."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz.errors import ArgumentError


def as_wavelengths(wavelengths: ArrayLike) -> NDArray[np.float64]:
    """Return wavelengths as a 1-D, finite, strictly ascending array [nm]."""
    values = as_numbers(wavelengths, "wavelengths")
    if values.ndim != 1 or values.size == 0:
        raise ArgumentError(
            f"wavelengths must be a 1-D array of at least one value in nm; "
            f"got shape {values.shape}"
        )
    if not np.all(np.isfinite(values)):
        raise ArgumentError("wavelengths must be finite; remove NaN or infinity")
    steps = np.flatnonzero(np.diff(values) <= 0)
    if steps.size:
        i = int(steps[0]) + 1
        raise ArgumentError(
            f"wavelengths must be strictly ascending; index {i} is "
            f"{values[i]:g} after {values[i - 1]:g} nm; sort them with their values"
        )
    return values


def as_spectra(values: ArrayLike, n_wavelengths: int, name: str) -> NDArray[np.float64]:
    """Return finite values as float64, wavelengths last and of that length."""
    array = as_numbers(values, name)
    require_spectra(array, n_wavelengths, name)
    bad = ~np.isfinite(array)
    if np.any(bad):
        raise ArgumentError(f"{name} must be finite; index {_first(bad)} is not")
    return array


def as_measured(
    values: ArrayLike, n_wavelengths: int, name: str
) -> NDArray[np.float32] | NDArray[np.float64]:
    """Return values that may be NaN where nothing was measured; float32 stays so."""
    array = np.asarray(values)
    if array.dtype != np.float32:
        array = as_numbers(values, name)
    require_spectra(array, n_wavelengths, name)
    bad = np.isinf(array)
    if np.any(bad):
        raise ArgumentError(
            f"{name} must be finite, or NaN where not measured; index {_first(bad)} "
            "is infinite"
        )
    return array


def require_spectra(array: NDArray[Any], n_wavelengths: int, name: str) -> None:
    """Refuse an array whose last axis is not the wavelengths."""
    if array.ndim == 0 or array.shape[-1] != n_wavelengths:
        raise ArgumentError(
            f"{name} must have the {n_wavelengths} wavelengths on its last axis; "
            f"got shape {array.shape}"
        )


def _first(bad: NDArray[np.bool_]) -> tuple[int, ...]:
    """Return the index of the first that is bad."""
    return tuple(int(i) for i in np.argwhere(bad)[0])


def in_range(value: float, low: float, high: float, name: str, unit: str = "") -> float:
    """Return a float within ``[low, high]`` or say what was expected."""
    if isinstance(value, bool | str) or not isinstance(value, SupportsFloat):
        raise ArgumentError(f"{name} must be a number; got {value!r}")
    number = float(value)
    if not low <= number <= high:
        raise ArgumentError(
            f"{name} must be in [{low:g}, {high:g}]{' ' + unit if unit else ''}; "
            f"got {number:g}"
        )
    return number


def as_numbers(value: ArrayLike, name: str) -> NDArray[np.float64]:
    """Return a float64 array or say what is no number."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} must be numbers; got {value!r}") from error


def unit_vector(value: ArrayLike, name: str) -> NDArray[np.float64]:
    """Return a 3-vector scaled to length 1."""
    vector = as_numbers(value, name)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise ArgumentError(f"{name} must be three finite numbers; got {value!r}")
    # Scaling first keeps the norm of huge and tiny vectors from over- or underflow.
    largest = np.abs(vector).max()
    if largest == 0:
        raise ArgumentError(f"{name} must not be the zero vector")
    vector = vector / largest
    return np.asarray(vector / np.linalg.norm(vector))


def one_of(value: Any, choices: Iterable[str], name: str) -> str:
    """Return the choice that was named, or list the valid ones, nearest first."""
    names = list(choices)
    if value in names:
        return str(value)
    near = get_close_matches(str(value), names, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    shown = ", ".join(names)
    raise ArgumentError(f"unknown {name} {value!r}; choose one of: {shown}{hint}")
