"""The curves beside the hand, as the chart component of the page takes them.

A chart is plain data, as Plotly's own figures are: traces and a layout.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz.errors import SkinvizError
from skinviz.scene.scene import Scene, Skin
from skinviz.skin.two_layer import TwoLayer
from skinviz.view.panels import spectral_colours
from skinviz.view.viewer.pictures import Shown
from skinviz.view.viewer.readings import Reading
from skinviz.view.viewer.samples import Sample

Array = NDArray[np.float64]
Chart = dict[str, Any]

VISIBLE = (400.0, 700.0)
"""What the wavelength axis shows. [nm]"""

_MEASURED, _FITTED, _OTHER = "#7f8c8d", "#d1495b", "#3a86c8"
_LAYERS, _LAYER_COLOURS = ("R<sub>e</sub>", "R<sub>d</sub>"), ("#9a6b4f", "#e07a3f")
_POINTS = ("#d1495b", "#3a86c8")
_STRIP_STEPS = 60
_STRIP_PIXELS = 7.0
_EVERY = 5.0  # nm


def reflectance_chart(shown: Shown) -> Chart:
    """Return the active hand's reflectance: measured, shown, and by layers."""
    state = shown.state
    sample, scene = shown.samples[state.active], shown.stages[state.active].scene
    wavelengths = _within(scene.skin.model.limits)
    skin = _mean(scene.skin)
    traces = []
    if sample.fit is not None and sample.measured is not None:
        traces.append(
            _trace(
                "measured",
                sample.fit.wavelengths,
                sample.measured,
                _MEASURED,
                mode="markers",
                marker={"size": 5, "color": _MEASURED},
            )
        )
    measured = skin.model.measured(skin.values, wavelengths)
    traces.append(_trace(_name_of(sample, scene.skin), wavelengths, measured, _FITTED))
    if isinstance(skin.model, TwoLayer):
        parts = skin.model.layers(skin.values, wavelengths)
        for label, values, colour in zip(_LAYERS, parts, _LAYER_COLOURS, strict=True):
            traces.append(_trace(label, wavelengths, values, colour, dash="dot"))
    return _chart(traces, "reflectance")


def _name_of(sample: Sample, skin: Skin) -> str:
    """Return what a hand's reflectance is: of the fit, set by hand, or a map's mean."""
    if skin.values.ndim == 2:
        return "mean"
    fit = sample.fit
    as_fitted = fit is not None and np.array_equal(fit.values, skin.values)
    return "fitted" if as_fitted else "set"


def radiance_chart(readings: tuple[Reading | None, ...]) -> Chart:
    """Return the radiance of the marked points, in its parts."""
    traces = []
    for name, colour, reading in zip("AB", _POINTS, readings, strict=False):
        if reading is None:
            continue
        spectrum = reading.spectrum
        middle = float(np.interp(560.0, spectrum.wavelengths, spectrum.white))
        unit = middle or float(spectrum.white.max())
        for part, values, dash in (
            ("", spectrum.diffuse + spectrum.specular, "solid"),
            (" diffuse", spectrum.diffuse, "dash"),
            (" specular", spectrum.specular, "dot"),
        ):
            traces.append(
                _trace(
                    f"{name}{part}",
                    spectrum.wavelengths,
                    values / unit,
                    colour,
                    dash=dash,
                )
            )
    return _chart(traces, "radiance / white")


def illuminant_chart(scene: Scene) -> Chart:
    """Return the spectra of the lights, each with 1 as its largest value."""
    traces = []
    for i, light in enumerate(scene.lights):
        lamp = light.spectrum
        if lamp.wavelengths.size:
            inside = (lamp.wavelengths >= VISIBLE[0]) & (lamp.wavelengths <= VISIBLE[1])
            power = lamp.power[inside]
            unit = float(power.max(initial=0.0)) or 1.0
            traces.append(
                _trace(lamp.name, lamp.wavelengths[inside], power / unit, _colour(i))
            )
        if len(lamp.lines):
            traces.append(_lines(lamp.name, lamp.lines, _colour(i)))
    return _chart(traces, "relative power")


def _mean(skin: Skin) -> Skin:
    """Return the mean of skin that differs over the hand."""
    return Skin(skin.model, np.atleast_2d(skin.values).mean(axis=0))


def _within(limits: tuple[float, float]) -> Array:
    """Return the wavelengths that curves are drawn at. [nm]"""
    low, high = max(limits[0], VISIBLE[0]), min(limits[1], VISIBLE[1])
    if low >= high:
        raise SkinvizError("the skin's coefficients hold no visible wavelength")
    return np.unique(np.append(np.arange(low, high, _EVERY), high))


def _colour(i: int) -> str:
    """Return the colour of the i-th light's curve."""
    return (_FITTED, _OTHER, *_LAYER_COLOURS)[i % 4]


def _trace(
    name: str, x: Array, y: Array, colour: str, *, dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """Return one curve."""
    return {
        "type": "scatter",
        "name": name,
        "x": np.round(x, 3).tolist(),
        # Bands that were not measured are gaps.
        "y": [
            value if np.isfinite(value) else None for value in np.round(y, 6).tolist()
        ],
        "mode": "lines",
        "line": {"color": colour, "width": 1.8, "dash": dash},
        "hovertemplate": "%{x:.0f} nm: %{y:.3f}",
        **more,
    }


def _lines(name: str, lines: Array, colour: str) -> dict[str, Any]:
    """Return a lamp's lines as spikes, the strongest as high as 1."""
    inside = lines[(lines[:, 0] >= VISIBLE[0]) & (lines[:, 0] <= VISIBLE[1])]
    unit = float(inside[:, 1].max(initial=0.0)) or 1.0
    x = np.repeat(inside[:, 0], 3)
    y = np.stack([0 * inside[:, 1], inside[:, 1] / unit, 0 * inside[:, 1]], 1).ravel()
    return _trace(f"{name} lines", x, y, colour)


def _chart(traces: list[dict[str, Any]], y: str) -> Chart:
    """Return a chart over wavelength with the visible colours under its axis."""
    highest = max((y for trace in traces for y in trace["y"] if y), default=0.0)
    rows = min(3, -(-len(traces) // 2))  # of the legend, which needs room above
    return {
        "data": traces,
        "layout": {
            "margin": {"l": 52, "r": 10, "t": 6, "b": 40},
            "xaxis": {
                "range": list(VISIBLE),
                "dtick": 50,
                "title": {"text": "wavelength (nm)", "standoff": 4},
                "ticklen": 9,
                "tickcolor": "rgba(0,0,0,0)",
                "fixedrange": True,
                "zeroline": False,
                "gridcolor": "rgba(128,128,128,0.18)",
            },
            "yaxis": {
                "range": [0.0, highest / (0.94 - 0.14 * rows) or 1.0],
                "title": {"text": y, "standoff": 6},
                "fixedrange": True,
                "zeroline": False,
                "nticks": 5,
                "gridcolor": "rgba(128,128,128,0.18)",
            },
            "legend": {
                "orientation": "h",
                "x": 0.01,
                "y": 1.0,
                "yanchor": "top",
                "bgcolor": "rgba(0,0,0,0)",
                "font": {"size": 10},
            },
            "font": {"size": 11, "family": "Roboto, sans-serif", "color": "#8a8a8a"},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "showlegend": True,
            "hovermode": "closest",
            "shapes": _strip(),
        },
    }


@cache
def _strip() -> list[dict[str, Any]]:
    """Return the visible colours as boxes under the axis, of a fixed height.

    Each reaches to the end, under the next, so that no gaps show between them.
    """
    edges = np.linspace(*VISIBLE, _STRIP_STEPS + 1)
    colours = np.rint(255 * spectral_colours((edges[1:] + edges[:-1]) / 2)).astype(int)
    return [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "x0": float(left),
            "x1": VISIBLE[1],
            "y0": 0.0,
            "y1": -_STRIP_PIXELS,
            "ysizemode": "pixel",
            "yanchor": 0.0,
            "line": {"width": 0},
            "fillcolor": f"rgb({r},{g},{b})",
            "layer": "below",
        }
        for left, (r, g, b) in zip(edges[:-1], colours.tolist(), strict=True)
    ]
