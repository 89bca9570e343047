"""What each control of the page shows of a state, and what it makes of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import ArgumentError
from skinviz.skin.model import Parameter
from skinviz.surface.models import surface_model
from skinviz.view.viewer.opened import Opened, has, index_of, width_of
from skinviz.view.viewer.samples import Sample
from skinviz.view.viewer.state import Look, ViewState
from skinviz.view.viewer.variables import MOST_WEIGHTS, PRESETS

Array = NDArray[np.float64]

_LARGE = 100.0  # an upper bound that is no more than one is a slider's end
_USUAL = {"w_m": 0.4, "w_h": 0.02, "w_dh": 0.02}  # ends of sliders, where they suffice
_LABELS = {
    "w_m": "melanin w_m",
    "w_h": "oxyhaemoglobin w_h",
    "w_dh": "deoxyhaemoglobin w_dh",
}
_WIDTH_LABELS = {
    "torrance-sparrow": ("half-width γ (rad)", 0.02, 1.0),
    "cook-torrance": ("roughness m", 0.02, 1.0),
    "phong": ("exponent", 0.0, 60.0),
    "lambert": ("", 0.0, 1.0),
}


def weight_controls(sample: Sample) -> list[dict[str, Any]]:
    """Return a control for each parameter of a hand's model, at most eight.

    ``low`` and ``high`` are the ends of the fit's 95 % interval as shares of the
    slider, both 0 where it is not known.
    """
    fitted = np.atleast_2d(sample.skin.values).mean(axis=0)
    controls = []
    for k, parameter in enumerate(sample.skin.model.parameters[:MOST_WEIGHTS]):
        interval = None if sample.interval is None else sample.interval[k]
        start, end = _ends(parameter, fitted[k], interval)
        low = high = 0.0
        if interval is not None:
            low, high = np.clip((interval - start) / (end - start), 0, 1)
        controls.append(
            {
                "name": parameter.name,
                "label": _LABELS.get(parameter.name, parameter.name),
                "unit": "" if parameter.unit == "1" else parameter.unit,
                "from": start,
                "to": end,
                "step": (end - start) / 500,
                "low": float(low),
                "high": float(high),
                "told": ""
                if interval is None
                else f"95 %: {interval[0]:.4f} to {interval[1]:.4f}",
            }
        )
    return controls


def _ends(
    parameter: Parameter, fitted: float, interval: Array | None
) -> tuple[float, float]:
    """Return where a parameter's slider begins and ends, its own value within."""
    if parameter.upper <= _LARGE:
        return parameter.lower, parameter.upper
    known = np.append([fitted], [] if interval is None else interval)
    most = 1.25 * float(known[np.isfinite(known)].max())
    return parameter.lower, _rounded_up(max(_USUAL.get(parameter.name, 0.0), most))


def weights_of(sample: Sample, look: Look) -> tuple[float, ...]:
    """Return the parameters that a hand has, the means of maps."""
    if look.weights:
        return look.weights
    return tuple(np.atleast_2d(sample.skin.values).mean(axis=0).tolist())


def saturation_of(sample: Sample, look: Look) -> float | None:
    """Return the oxygen saturation, None where a model or skin has no blood."""
    names = [parameter.name for parameter in sample.skin.model.parameters]
    if not {"w_h", "w_dh"} <= set(names):
        return None
    weights = weights_of(sample, look)
    oxy, deoxy = weights[names.index("w_h")], weights[names.index("w_dh")]
    return oxy / (oxy + deoxy) if oxy + deoxy > 0 else None


def with_weight(state: ViewState, sample: Sample, k: int, value: float) -> ViewState:
    """Return the state with one parameter of the active hand changed."""
    weights = list(weights_of(sample, state.look))
    if not 0 <= k < len(weights):
        raise ArgumentError(f"the model has {len(weights)} weights; got {k}")
    if math.isclose(weights[k], value, rel_tol=1e-12, abs_tol=1e-15):
        return state
    weights[k] = float(value)
    return state.with_look(weights=tuple(weights))


def with_saturation(state: ViewState, sample: Sample, share: float) -> ViewState:
    """Return the state with the active hand's blood oxygenated otherwise."""
    present = saturation_of(sample, state.look)
    if present is None or math.isclose(present, share, rel_tol=1e-9, abs_tol=1e-12):
        return state
    names = [parameter.name for parameter in sample.skin.model.parameters]
    weights = list(weights_of(sample, state.look))
    oxy, deoxy = names.index("w_h"), names.index("w_dh")
    blood = weights[oxy] + weights[deoxy]
    weights[oxy], weights[deoxy] = blood * share, blood * (1 - share)
    return state.with_look(weights=tuple(weights))


def with_preset(state: ViewState, name: str) -> ViewState:
    """Return the state with light and viewer at angles such as "60/60"."""
    if name not in PRESETS:
        raise ArgumentError(f"angles must be one of {', '.join(PRESETS)}; got {name!r}")
    light, view = (float(angle) for angle in name.split("/"))
    return state.replace(light=(light, 0.0), view=(view, 0.0, 0.0))


def with_surface(state: ViewState, opened: Opened, name: str) -> ViewState:
    """Return the state with another surface model, as the model has it itself."""
    if name == state.surface:
        return state
    if name == opened.initial.surface:
        made = opened.scene.surface
    else:
        made = surface_model(name)
    gains_index = has(name, "n") and not has(state.surface, "n")
    return state.replace(
        surface=name,
        width=width_of(made),
        index=index_of(made) if gains_index else state.index,
        specular_scale=float(getattr(made, "specular_scale", 1.0)),
    )


def surface_control(name: str) -> dict[str, Any]:
    """Return which sliders a surface model has, and from where to where."""
    label, low, high = _WIDTH_LABELS[name]
    return {
        "width": label,
        "from": low,
        "to": high,
        "step": (high - low) / 500,
        "n": has(name, "n"),
        "scale": has(name, "specular_scale"),
    }


def control_values(state: ViewState) -> dict[str, Any]:
    """Return what the page's variables are in a state, but for the skin's."""
    return {name: read(state) for name, (read, _) in CONTROLS.items()}


def _in_stops(exposure: float) -> float:
    """Return an exposure in steps of two."""
    return round(math.log2(exposure), 4)


def _set(name: str) -> Callable[[ViewState, Any], ViewState]:
    """Return what sets an attribute."""
    return lambda state, value: state.replace(**{name: value})


def _part(name: str, k: int) -> tuple[Any, Any]:
    """Return what reads and what sets one number of several."""

    def write(state: ViewState, value: Any) -> ViewState:
        numbers = list(getattr(state, name))
        numbers[k] = value
        return state.replace(**{name: tuple(numbers)})

    return (lambda state: getattr(state, name)[k]), write


CONTROLS: dict[
    str, tuple[Callable[[ViewState], Any], Callable[[ViewState, Any], ViewState]]
] = {
    "illuminant": (lambda state: state.illuminant, _set("illuminant")),
    "light_angle": _part("light", 0),
    "light_tilt": _part("light", 1),
    "view_angle": _part("view", 0),
    "view_tilt": _part("view", 1),
    "width": (lambda state: state.width, _set("width")),
    "index": (lambda state: state.index, lambda s, v: s.replace(index=str(v or ""))),
    "specular_scale": (lambda state: state.specular_scale, _set("specular_scale")),
    "stops": (
        lambda state: _in_stops(state.exposure),
        lambda state, value: state.replace(exposure=2.0**value),
    ),
    "adapted": (
        lambda state: state.white == "cat16",
        lambda state, value: state.replace(white="cat16" if value else "none"),
    ),
    "tolerance_log": (
        lambda state: round(math.log10(state.tolerance), 4),
        lambda state, value: state.replace(tolerance=round(10.0**value, 4)),
    ),
    "hands": (lambda state: len(state.looks), lambda s, value: s.with_hands(value)),
    "active": (lambda state: state.active, _set("active")),
    "difference": (lambda state: state.difference, _set("difference")),
}
"""Variables of the page by name: how each is read from a state, and set."""


def _rounded_up(value: float) -> float:
    """Return a value with two digits, not below it."""
    if value <= 0:
        return 1.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(math.ceil(value / unit - 1e-9) * unit)
