"""The page's variables, with what they are before anything is opened.

Light to load: the page is laid out with these while the scene is still being read.
"""

from __future__ import annotations

from typing import Any

MOST_WEIGHTS = 8
"""Parameters of a model that have a control."""

PRESETS = ("0/0", "30/0", "60/0", "60/60")
"""Angles of light and viewer that the paper's pictures have."""

CHARTS = ("reflectance", "radiance", "illuminant")
"""What curves are drawn of."""

_EMPTY: dict[str, Any] = {"data": [], "layout": {}}

FIRST: dict[str, Any] = {
    "opened": False,
    "title": "",
    "notice": None,
    "busy": True,
    "browsers": 1,
    # The picture and what is written on it.
    "picture": "",
    "still": False,
    "aspect": "1 / 1",
    "query": "",
    "quick_ms": 0,
    "points": [],
    "point_difference": None,
    "names": [],
    "legend": None,
    **{f"{name}_chart": _EMPTY for name in CHARTS},
    # Whose skin, and what of it.
    "group": None,
    "groups": [],
    "person": None,
    "people": [],
    "site": None,
    "sites": [],
    "skin_name": "",
    "skin_changed": False,
    "weights": [],
    **{f"weight_{k}": None for k in range(MOST_WEIGHTS)},
    "saturation": None,
    # Light, view, surface and picture.
    "lamps": [],
    "illuminant": "",
    "light_angle": 0.0,
    "light_tilt": 0.0,
    "presets": list(PRESETS),
    "view_angle": 0.0,
    "view_tilt": 0.0,
    "surfaces": [],
    "surface": "",
    "surface_control": {"width": "", "from": 0, "to": 1, "step": 0.01},
    "width": 0.0,
    "index": "",
    "specular_scale": 1.0,
    "beta": "",
    "stops": 0.0,
    "adapted": False,
    "tolerance_log": 0.0,
    "plan": [],
    "plan_head": "",
    "notes": [],
    "hands": 1,
    "active": 0,
    "difference": False,
}
"""Variables that the server sets, and some that browsers set too."""

OWN: dict[str, Any] = {
    "theme": "light",
    "notice_open": False,
    "command": "",
    "file_name": "view",
}
"""Variables of each browser alone."""
