"""The page: what stands where. It computes nothing."""

from __future__ import annotations

from typing import Any

from skinviz.view.viewer.page_controls import build_controls
from skinviz.view.viewer.page_curves import build_curves
from skinviz.view.viewer.variables import FIRST, OWN

_HINT = (
    "drag or arrows: turn · Shift: shift · wheel or + −: zoom · 0: whole hand · "
    "click: mark A · Shift-click: mark B · Ctrl-Z: undo"
)


def build_page(server: Any) -> None:
    """Lay the page out on a trame server."""
    from trame.ui.vuetify3 import VAppLayout
    from trame.widgets import client, html
    from trame.widgets import vuetify3 as v

    server.state.trame__title = "skinviz"
    server.state.client_only(*OWN)
    server.state.update({**FIRST, **OWN})
    with VAppLayout(server, theme=("theme", "light")) as layout, layout.root:
        client.ClientTriggers(mounted="window.skinviz.begin()")
        with html.Div(classes="sv-page"):
            _build_head(v, html)
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


def _build_head(v: Any, html: Any) -> None:
    """Lay out the line at the top."""
    with html.Header(classes="sv-head"):
        html.Span("skinviz", classes="sv-title")
        html.Span("{{ title }}", classes="sv-file")
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
            html.Span("{{ opened ? 'computing' : 'opening the scene' }}")
        with html.Div(
            classes="sv-frame",
            v_show="picture",
            style=("`--aspect: ${aspect}`",),
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
