"""What the page tells in words and numbers, as plain data for its variables."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz.rendering.finding import Finding
from skinviz.spectra.illuminants import illuminants
from skinviz.surface.models import surface_models
from skinviz.view.viewer.controls import (
    control_values,
    saturation_of,
    surface_control,
    weight_controls,
    weights_of,
)
from skinviz.view.viewer.curves import (
    illuminant_chart,
    radiance_chart,
    reflectance_chart,
)
from skinviz.view.viewer.opened import Opened
from skinviz.view.viewer.pictures import Shown, Still, difference_colours
from skinviz.view.viewer.readings import Reading, difference_of, readings_of
from skinviz.view.viewer.samples import ANY_GROUP, Samples
from skinviz.view.viewer.variables import MOST_WEIGHTS

_STEPS = 9  # of the difference map's legend


def opening_told(opened: Opened) -> dict[str, Any]:
    """Return what is told of what was opened, once."""
    samples = opened.samples
    return {
        "opened": True,
        "busy": False,
        "title": opened.name,
        "trame__title": f"skinviz: {opened.name}",
        "groups": samples.groups(),
        "people": samples.people(ANY_GROUP),
        "lamps": _lamps(opened),
        "surfaces": list(surface_models()),
        "surface": opened.initial.surface,
        **control_values(opened.initial),
    }


def told_of(shown: Shown, samples: Samples) -> dict[str, Any]:
    """Return everything but the picture that a state shows and browsers do not set."""
    readings, person = readings_of(shown), shown.state.look.person
    return {
        **skin_told(shown),
        "sites": samples.sites(person) if person else [],
        "surface_control": surface_control(shown.state.surface),
        "points": [
            _point(name, one) for name, one in zip("AB", readings, strict=False)
        ],
        "point_difference": difference_of(readings),
        "reflectance_chart": reflectance_chart(shown),
        "radiance_chart": radiance_chart(readings),
        "illuminant_chart": illuminant_chart(shown.stages[0].scene),
        "names": _names(shown),
        "legend": _legend(shown.scale) if shown.state.difference else None,
        "beta": f"{shown.stages[0].scene.surface.beta:.4g}",
    }


def skin_told(shown: Shown) -> dict[str, Any]:
    """Return the controls of the active hand's skin."""
    state = shown.state
    sample = shown.samples[state.active]
    return {
        "weights": weight_controls(sample),
        "skin_name": sample.name,
        "skin_changed": bool(state.look.weights),
    }


def settings_of(shown: Shown) -> dict[str, Any]:
    """Return the variables that browsers set, as they are in a state."""
    state = shown.state
    sample = shown.samples[state.active]
    weights = weights_of(sample, state.look)[:MOST_WEIGHTS]
    return {
        **control_values(state),
        **{f"weight_{k}": value for k, value in enumerate(weights)},
        "saturation": saturation_of(sample, state.look),
        "surface": state.surface,
        "person": state.look.person or None,
        "site": state.look.site or None,
    }


def plan_told(still: Still, tolerance: float) -> dict[str, Any]:
    """Return what the still picture's plan is, knob by knob."""
    return {
        "plan": [_finding(finding) for finding in still.plan.findings],
        "plan_head": f"ΔE00 ≤ {tolerance:g}, {1e3 * still.seconds:.0f} ms",
        "notes": list(still.notes),
    }


def _finding(finding: Finding) -> dict[str, str]:
    """Return what was found of one knob."""
    known = finding.delta_e is not None and (finding.left_out or finding.delta_e)
    change = f"ΔE00 {finding.delta_e:.3f}" if known else ""
    saved = f"saves {finding.saved:.0f} ms" if finding.saved > 0.5 else ""
    return {
        "knob": finding.knob,
        "chosen": finding.chosen,
        "left_out": finding.left_out,
        "told": ", ".join(word for word in (change, saved) if word),
    }


def _lamps(opened: Opened) -> list[dict[str, str]]:
    """Return the lamps to choose from, the scene's own first."""
    own = opened.scene.lights[0].spectrum.name
    return [
        {"title": f"{own} (the scene's)", "value": ""},
        *({"title": name, "value": name} for name in illuminants()),
    ]


def _point(name: str, reading: Reading | None) -> dict[str, Any]:
    """Return what is told of a marked point."""
    if reading is None:
        return {"name": name, "seen": False}
    return {
        "name": name,
        "seen": True,
        "hex": reading.hex,
        "left": f"{100 * reading.at[0]:.3f}%",
        "top": f"{100 * reading.at[1]:.3f}%",
        "lab": [f"{value:.2f}" for value in reading.lab],
        "rgb": list(reading.rgb),
        "place": ", ".join(f"{x:.1f}" for x in reading.mark.place),
    }


def _names(shown: Shown) -> list[dict[str, str]]:
    """Return what is written over each tile, and where."""
    width, height = shown.tiles.whole
    names = [
        f"{i + 1}  {sample.name}" + (" (changed)" if look.weights else "")
        for i, (sample, look) in enumerate(
            zip(shown.samples, shown.state.looks, strict=True)
        )
    ]
    if shown.state.difference:
        names.append("ΔE00 between 1 and 2")
    placed = []
    for tile, name in enumerate(names):
        left, top = shown.tiles.corner(tile)
        placed.append(
            {
                "name": name,
                "left": f"{100 * left / width:.3f}%",
                "top": f"{100 * top / height:.3f}%",
                "width": f"{100 * shown.tiles.size[0] / width:.3f}%",
            }
        )
    return placed if len(placed) > 1 else []


def _legend(scale: float) -> dict[str, str]:
    """Return the difference map's colours, and what its ends stand for."""
    steps = np.linspace(0, 255, _STEPS).astype(int)
    colours = ", ".join(f"#{bytes(row).hex()}" for row in difference_colours()[steps])
    return {"gradient": f"linear-gradient(to right, {colours})", "to": f"{scale:g}"}
