"""The surface models by name."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from skinviz._validate import one_of
from skinviz.errors import ArgumentError
from skinviz.surface.cook_torrance import CookTorrance
from skinviz.surface.dispersion import dispersion
from skinviz.surface.lambert import Lambert
from skinviz.surface.phong import Phong
from skinviz.surface.surface import Surface
from skinviz.surface.torrance_sparrow import TorranceSparrow

_MODELS: dict[str, type[Surface]] = {
    model.name: model for model in (TorranceSparrow, CookTorrance, Phong, Lambert)
}


def surface_models() -> tuple[str, ...]:
    """Return the names that :func:`surface_model` knows."""
    return tuple(_MODELS)


def surface_parameters(name: str) -> tuple[str, ...]:
    """Return the parameters by which :func:`surface_model` makes a model."""
    model = _MODELS[one_of(name, _MODELS, "surface model")]
    own = tuple(field.name for field in fields(model))
    return (*own, "beta") if hasattr(model, "from_beta") else own


def surface_model(name: str = "torrance-sparrow", **parameters: Any) -> Surface:
    """Return a model of the skin's surface by name.

    Parameters
    ----------
    name : str
        One of :func:`surface_models`.
    **parameters
        Of the model, as :func:`surface_parameters` lists them; the rest stays as
        the model's own. ``n`` may be the name of a tissue, "epidermis" or "dermis",
        whose index varies with wavelength; "torrance-sparrow" also takes ``beta``,
        the weight of eq. (10), instead of ``specular_scale``.

    Returns
    -------
    surface : Surface
        Frozen.

    Raises
    ------
    ArgumentError
        If the name or a parameter is unknown, or a value impossible.

    Examples
    --------
    >>> from skinviz.surface import surface_model
    >>> surface_model("cook-torrance", roughness=0.25).description
    'Cook-Torrance, Beckmann slope 0.25, n 1.4, 1 of the physical, masking v-cavity'
    """
    known = surface_parameters(name)
    for parameter in parameters:
        if parameter not in known:
            raise ArgumentError(
                f"surface {name!r} has no parameter {parameter!r}; it has "
                f"{', '.join(known) or 'none'}"
            )
    if isinstance(parameters.get("n"), str):
        parameters["n"] = dispersion(parameters["n"])
    if "beta" not in parameters:
        return _MODELS[name](**parameters)
    if "specular_scale" in parameters:
        raise ArgumentError("a surface takes beta or specular_scale, not both")
    return TorranceSparrow.from_beta(**parameters)
