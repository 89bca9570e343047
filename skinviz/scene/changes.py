"""What if: skin with more melanin, more blood, less oxygen.

A change is a word: ``x2`` multiplies, ``+0.01`` and ``-0.01`` add, a number sets.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.skin.model import SkinModel

Array = NDArray[np.float64]
Weights = dict[str, Array]

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WORD = re.compile(rf"([x×]|[+-])?({_NUMBER})")


@dataclass(frozen=True)
class _Change:
    """A word, understood."""

    kind: str
    number: float

    def of(self, old: Array) -> Array:
        """Return what it makes of some values."""
        if self.kind == "x":
            return old * self.number
        return old + self.number if self.kind == "+" else np.full_like(old, self.number)


def _of_weight(name: str) -> Callable[[Weights, _Change], Weights]:
    """Return what changes one weight."""

    def changed(weights: Weights, change: _Change) -> Weights:
        return {**weights, name: change.of(weights[name])}

    return changed


def _of_blood(weights: Weights, change: _Change) -> Weights:
    """Change all blood, its saturation kept."""
    blood, saturation = _blood(weights), _saturation(weights)
    return _mixed(weights, change.of(blood), saturation)


def _of_saturation(weights: Weights, change: _Change) -> Weights:
    """Change the saturation, all blood kept."""
    saturation = change.of(_saturation(weights))
    low, high = saturation.min(), saturation.max()
    if low < 0 or high > 1:
        raise ArgumentError(
            f"saturation must stay within 0 and 1; the change makes it "
            f"{low if low < 0 else high:.4g}"
        )
    return _mixed(weights, _blood(weights), saturation)


def _mixed(weights: Weights, blood: Array, saturation: Array) -> Weights:
    """Return weights with so much blood, so much of it with oxygen."""
    return {**weights, "w_h": blood * saturation, "w_dh": blood * (1 - saturation)}


def _blood(weights: Weights) -> Array:
    """Return all blood."""
    return weights["w_h"] + weights["w_dh"]


def _saturation(weights: Weights) -> Array:
    """Return the share of blood with oxygen; 0 where there is none."""
    blood = _blood(weights)
    out = np.zeros_like(blood)
    return np.divide(weights["w_h"], blood, out=out, where=blood > 0)


_QUANTITIES: dict[str, tuple[Callable[[Weights, _Change], Weights], set[str]]] = {
    "melanin": (_of_weight("w_m"), {"w_m"}),
    "oxyhaemoglobin": (_of_weight("w_h"), {"w_h"}),
    "deoxyhaemoglobin": (_of_weight("w_dh"), {"w_dh"}),
    "haemoglobin": (_of_blood, {"w_h", "w_dh"}),
    "saturation": (_of_saturation, {"w_h", "w_dh"}),
}
QUANTITIES = tuple(_QUANTITIES)
"""What can be changed, in the order in which changes are made."""


def changed_values(
    model: SkinModel, values: Array, changes: Mapping[str, str | float]
) -> Array:
    """Return a model's parameters with some quantities changed.

    Parameters
    ----------
    model : SkinModel
        Whose parameters they are.
    values : (..., p) ndarray
        Its parameters.
    changes : mapping of str to str or float
        By quantity: ``melanin`` (w_m), ``oxyhaemoglobin`` (w_h), ``deoxyhaemoglobin``
        (w_dh), ``haemoglobin`` (their sum, at the same saturation) and ``saturation``
        (at the same sum). ``"x2"`` multiplies, ``"+0.01"`` and ``"-0.01"`` add, a
        number sets. They are made in this order.

    Returns
    -------
    values : (..., p) ndarray
        Where there is no blood its saturation is 0, and stays so.

    Raises
    ------
    ArgumentError
        If a quantity is unknown or not the model's, a word is no change, or the
        result is negative or out of the model's bounds.
    """
    names = [parameter.name for parameter in model.parameters]
    for name in changes:
        one_of(name, QUANTITIES, "quantity to change")
    weights = dict(zip(names, np.moveaxis(values, -1, 0), strict=True))
    for name, (change, needed) in _QUANTITIES.items():
        if name not in changes:
            continue
        if not needed <= weights.keys():
            raise ArgumentError(
                f"the {model.name} model has no {name} to change; its parameters are "
                f"{', '.join(names)}"
            )
        weights = change(weights, _parsed(name, changes[name]))
        _require_bounds(model, name, str(changes[name]), weights)
    return np.stack([weights[name] for name in names], axis=-1)


def told(changes: Mapping[str, str | float]) -> str:
    """Return changes in words."""
    return ", ".join(
        f"{name} {str(changes[name]).replace('×', 'x')}"
        for name in QUANTITIES
        if name in changes
    )


def _parsed(name: str, word: str | float) -> _Change:
    """Return the change that a word or a number says."""
    text = f"{word:.17g}" if type(word) in (int, float) else str(word).strip()
    found = _WORD.fullmatch(text)
    if found is None:
        raise ArgumentError(
            f"{name} must be x2 (to multiply), +0.01 or -0.01 (to add), or a number of "
            f"at least 0 (to set); got {word!r}"
        )
    sign, number = found.groups()
    value = float(number)
    if not np.isfinite(value):
        raise ArgumentError(f"{name} must be a finite number; got {word!r}")
    if sign in ("+", "-"):
        return _Change("+", value if sign == "+" else -value)
    return _Change("x" if sign else "=", value)


def _require_bounds(model: SkinModel, name: str, word: str, weights: Weights) -> None:
    """Refuse what no skin of the model has."""
    for parameter in model.parameters:
        own = weights[parameter.name]
        low, high = float(own.min()), float(own.max())
        if not (low >= parameter.lower and high <= parameter.upper):
            wrong = high if low >= parameter.lower else low
            raise ArgumentError(
                f"{name} {word} makes {parameter.name} {wrong:.4g}; it must be between "
                f"{parameter.lower:g} and {parameter.upper:g}"
            )
