"""The skin models by name."""

from __future__ import annotations

import numpy as np

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.skin.coefficients import body_sites, layer_thickness, load_coefficients
from skinviz.skin.model import SkinModel
from skinviz.skin.two_layer import TwoLayer

_MODELS = {TwoLayer.name: TwoLayer}


def skin_models() -> tuple[str, ...]:
    """Return the names that :func:`skin_model` knows."""
    return tuple(_MODELS)


def skin_model(
    name: str = "two-layer",
    *,
    specular: str | float,
    site: str | None = None,
    thickness: tuple[float, float] | None = None,
    coefficients: str = "effective",
    hypodermis: float = 1.0,
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
    coefficients : str
        ``"effective"`` or ``"textbook"``.
    hypodermis : float
        Reflectance of the white backing under the dermis. [1], 0 to 1

    Returns
    -------
    model : SkinModel
        Frozen; holds no fit.

    Raises
    ------
    ArgumentError
        If a name is unknown, or not exactly one of ``site`` and ``thickness`` is
        given.

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
    return kind(depths, load_coefficients(coefficients), specular, hypodermis)


def _two_depths(thickness: object) -> tuple[float, float]:
    """Return a given thickness as two numbers or say what was expected."""
    try:
        epidermis, dermis = np.asarray(thickness, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"thickness must be (epidermis, dermis) in mm; got {thickness!r}"
        ) from error
    return float(epidermis), float(dermis)
