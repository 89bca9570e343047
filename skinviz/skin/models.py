"""The skin models by name."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import (
    Coefficients,
    body_sites,
    layer_thickness,
    load_coefficients,
)
from skinviz.skin.cotton import Cotton
from skinviz.skin.extended import Extended
from skinviz.skin.lambert_beer import LambertBeer
from skinviz.skin.model import SkinModel
from skinviz.skin.two_layer import TwoLayer

_MODELS: dict[str, type[SkinModel]] = {
    model.name: model for model in (TwoLayer, Cotton, LambertBeer, Extended)
}


def skin_models() -> tuple[str, ...]:
    """Return the names that :func:`skin_model` knows."""
    return tuple(_MODELS)


def skin_model(
    name: str = "two-layer",
    *,
    specular: str | float,
    site: str | None = None,
    thickness: tuple[float, float] | None = None,
    coefficients: str | os.PathLike[str] | Coefficients = "effective",
    hypodermis: float = 1.0,
    free: Sequence[str] | None = None,
) -> SkinModel:
    """Return a model of skin, ready to compute spectra or to be fitted.

    Parameters
    ----------
    name : str
        One of :func:`skin_models`.
    specular : {"excluded", "included"} or float
        How the spectra were measured: 45/0 excludes the surface reflection, a
        sphere with its port closed includes it, a number is added as a constant.
        There is no default, because the weights depend on it.
    site : str, optional
        Body site whose layer thickness (Table I) to use.
    thickness : (float, float), optional
        Thickness of epidermis and dermis instead. [mm]
    coefficients : str, path-like or Coefficients
        ``"effective"``, ``"textbook"``, or a table of your own: the path of a CSV, see
        :func:`load_coefficients`.
    hypodermis : float
        Reflectance of the white backing under the dermis. [1], 0 to 1
    free : sequence of str, optional
        What the ``"extended"`` model leaves free besides the pigments, of
        ``"scattering"``, ``"melanin_slope"``, ``"surface"`` and ``"epidermis"``; the
        first three if not said.

    Returns
    -------
    model : SkinModel
        Frozen; holds no fit.

    Raises
    ------
    ArgumentError
        If a name is unknown, not exactly one of ``site`` and ``thickness`` is
        given, or ``free`` is given to another model.
    DataError
        If a coefficient table of your own cannot be read.

    Examples
    --------
    >>> model = skin_model(site="back of hand", specular="included")
    >>> model.measured([0.1, 0.005, 0.005], [450, 550, 650]).shape
    (3,)
    """
    kind = _MODELS[one_of(name, _MODELS, "skin model")]
    if (site is None) == (thickness is None):
        raise ArgumentError(
            "give exactly one of site and thickness; sites are "
            + ", ".join(body_sites())
        )
    depths = layer_thickness(site) if site is not None else _two_depths(thickness)
    table = load_coefficients(coefficients)
    if free is None:
        return kind(depths, table, specular, hypodermis)
    if kind is not Extended:
        raise ArgumentError(
            f"only the {Extended.name} model leaves more than the weights free; got "
            f"free = {list(free)} for {name}"
        )
    return Extended(depths, table, specular, hypodermis, tuple(free))


def _two_depths(thickness: object) -> tuple[float, float]:
    """Return a given thickness as two numbers or say what was expected."""
    try:
        epidermis, dermis = np.asarray(thickness, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"thickness must be (epidermis, dermis) in mm; got {thickness!r}"
        ) from error
    return float(epidermis), float(dermis)
