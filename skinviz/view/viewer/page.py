"""The page: what stands where. It computes nothing."""

from __future__ import annotations

from typing import Any

from skinviz.spectra.illuminants import illuminants
from skinviz.view.viewer.controls import CONTROLS, MOST_WEIGHTS, PRESETS, control_values
from skinviz.view.viewer.opened import Opened
from skinviz.view.viewer.page_controls import build_controls
from skinviz.view.viewer.page_curves import build_curves

_HINT = (
    "drag or arrows: turn · Shift: shift · wheel or + −: zoom · 0: whole hand · "
    "click: mark A · Shift-click: mark B · Ctrl-Z: undo"
)


def build_page(server: Any, opened: Opened) -> None:
    """Lay the page out on a trame server."""
    from trame.ui.vuetify3 import VAppLayout
    from trame.widgets import client, html
    from trame.widgets import vuetify3 as v

    _set_variables(server, opened)
    with VAppLayout(server, theme=("theme", "light")) as layout, layout.root:
        client.ClientTriggers(mounted="window.skinviz.begin()")
        with html.Div(classes="sv-page"):
            _build_head(v, html, opened)
            build_controls(v, html)
            _build_middle(v, html)
            build_curves(html)
            _build_foot(html)
        with v.VSnackbar(
            v_model=("notice_open", False),
            timeout=8000,
            color=("notice?.bad ? 'error' : 'success'",),
            location="bottom",
            __properties=["location"],
        ):
            html.Span("{{ notice?.text }}", classes="sv-notice")
        client.ClientStateChange(value="notice", change="notice_open = !!notice")


def _set_variables(server: Any, opened: Opened) -> None:
    """Give every variable of the page a first value."""
    state, samples = server.state, opened.samples
    state.trame__title = f"skinviz: {opened.name}"
    state.client_only("theme", "notice_open", "command", "file_name", "group_open")
    state.update(
        {
            "theme": "light",
            "notice": None,
            "notice_open": False,
            "command": "",
            "file_name": "view",
            "busy": False,
            "still": False,
            "browsers": 1,
            "picture": "",
            "aspect": "1 / 1",
            "query": "",
            "quick_ms": 0,
            "points": [],
            "names": [],
            "legend": None,
            "point_difference": None,
            "plan": [],
            "plan_head": "",
            "notes": [],
            "weights": [],
            "saturation": None,
            "skin_name": "",
            "skin_changed": False,
            "beta": "",
            "surface": opened.initial.surface,
            "surface_control": {"width": "", "from": 0, "to": 1, "step": 0.01},
            "group": None,
            "groups": samples.groups(),
            "people": samples.people(""),
            "person": None,
            "site": None,
            "sites": [],
            "lamps": _lamps(opened),
            "presets": list(PRESETS),
            **{f"weight_{k}": None for k in range(MOST_WEIGHTS)},
            **dict.fromkeys(CONTROLS),
            **control_values(opened.initial),
            **{
                f"{name}_chart": {"data": [], "layout": {}}
                for name in ("reflectance", "radiance", "illuminant")
            },
        }
    )


def _lamps(opened: Opened) -> list[dict[str, str]]:
    """Return the lamps to choose from, the scene's own first."""
    own = opened.scene.lights[0].spectrum.name
    return [
        {"title": f"{own} (the scene's)", "value": ""},
        *({"title": name, "value": name} for name in illuminants()),
    ]


def _build_head(v: Any, html: Any, opened: Opened) -> None:
    """Lay out the line at the top."""
    with html.Header(classes="sv-head"):
        html.Span("skinviz", classes="sv-title")
        html.Span(opened.name, classes="sv-file")
        v.VSpacer()
        for icon, name, title in (
            ("mdi-undo", "undo", "Undo (Ctrl-Z)"),
            ("mdi-redo", "redo", "Redo (Ctrl-Y)"),
            ("mdi-restart", "reset", "Reset everything"),
        ):
            v.VBtn(
                icon=icon,
                title=title,
                variant="text",
                density="comfortable",
                size="small",
                click=f"window.skinviz.ask('{name}')",
                __properties=["title"],
                raw_attrs=[f'aria-label="{title}" data-test="{name}"'],
            )
        v.VBtn(
            icon="mdi-theme-light-dark",
            title="Light or dark",
            variant="text",
            density="comfortable",
            size="small",
            click="window.skinviz.theme()",
            __properties=["title"],
            raw_attrs=['aria-label="Light or dark" data-test="theme"'],
        )


def _build_middle(v: Any, html: Any) -> None:
    """Lay out the picture and what is written on it."""
    with html.Main(
        classes="sv-middle",
        raw_attrs=[':ref="(e) => window.skinviz.observe(e)" data-test="middle"'],
    ):
        with html.Div(classes="sv-busy", v_if="busy", raw_attrs=['role="status"']):
            v.VProgressCircular(indeterminate=True, size=16, width=2)
            html.Span("computing")
        with html.Div(
            classes="sv-frame",
            v_show="picture",
            style=("`aspect-ratio: ${aspect}`",),
        ):
            html.Img(
                src=("picture",),
                alt="The hand as computed",
                tabindex=0,
                draggable="false",
                raw_attrs=[
                    'data-test="picture"',
                    ':data-still="still"',
                    '@pointerdown="window.skinviz.down($event)"',
                    '@pointermove="window.skinviz.move($event)"',
                    '@pointerup="window.skinviz.up($event)"',
                    '@pointercancel="window.skinviz.up($event)"',
                    '@wheel="window.skinviz.wheel($event)"',
                    '@keydown="window.skinviz.key($event)"',
                ],
            )
            with html.Div(
                v_for="point in points.filter((p) => p.seen)",
                key="point.name",
                classes="sv-mark",
                style=("`left: ${point.left}; top: ${point.top}`",),
            ):
                html.Span("{{ point.name }}")
            html.Div(
                "{{ tile.name }}",
                v_for="tile in names",
                key="tile.name",
                classes="sv-name",
                style=(
                    "`left: ${tile.left}; top: ${tile.top}; max-width: ${tile.width}`",
                ),
            )
            with html.Div(v_if="legend", classes="sv-scale"):
                html.Div(style=("`background: ${legend.gradient}`",))
                with html.Div(classes="sv-row"):
                    html.Span("0")
                    html.Span("ΔE00")
                    html.Span("{{ legend.to }}")


def _build_foot(html: Any) -> None:
    """Lay out the line at the bottom."""
    with html.Footer(classes="sv-foot"):
        html.Span(
            "{{ still ? 'still: ' + plan_head : 'moving: ' + quick_ms + ' ms' }}",
            raw_attrs=['data-test="status"'],
        )
        html.Span(
            "{{ browsers }} browsers share this view: what one sets, all see",
            v_if="browsers > 1",
            raw_attrs=['data-test="browsers"'],
        )
        html.Span(_HINT, classes="sv-hint")
