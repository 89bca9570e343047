"""The left side of the page: everything that can be set."""

from __future__ import annotations

from typing import Any

from skinviz.view.viewer.page_parts import group, select, slider
from skinviz.view.viewer.page_skin import build_hands, build_skin


def build_controls(v: Any, html: Any) -> None:
    """Lay out the left side."""
    with html.Nav(classes="sv-controls", raw_attrs=['aria-label="Controls"']):
        build_hands(v, html)
        build_skin(v, html)
        _build_light(v, html)
        _build_view(v, html)
        _build_surface(v, html)
        _build_picture(v, html)
        _build_saving(v, html)


def _build_light(v: Any, html: Any) -> None:
    """Lay out the light."""
    with group(html, "Light"):
        select(v, "illuminant", "illuminant", "lamps")
        slider(
            *(v, html, "light_angle", "angle", (-90, 90, 1)),
            told="light_angle.toFixed(0) + '°'",
        )
        slider(
            *(v, html, "light_tilt", "tilt", (-90, 90, 1)),
            told="light_tilt.toFixed(0) + '°'",
        )


def _build_view(v: Any, html: Any) -> None:
    """Lay out the viewer's place."""
    with group(html, "View"):
        with html.Div(classes="sv-row"):
            html.Span("light/view")
            with html.Div(classes="sv-buttons"):
                v.VBtn(
                    "{{ preset }}",
                    v_for="preset in presets",
                    key="preset",
                    size="x-small",
                    variant="outlined",
                    click="window.skinviz.ask('preset', [preset])",
                )
        slider(
            *(v, html, "view_angle", "angle", (-180, 180, 1)),
            told="view_angle.toFixed(0) + '°'",
        )
        slider(
            *(v, html, "view_tilt", "tilt", (-90, 90, 1)),
            told="view_tilt.toFixed(0) + '°'",
        )


def _build_surface(v: Any, html: Any) -> None:
    """Lay out the surface."""
    with group(html, "Surface"):
        v.VSelect(
            v_model=("surface",),
            items=("surfaces",),
            label="model",
            density="compact",
            variant="outlined",
            hide_details=True,
            classes="my-2",
            raw_attrs=['data-test="surface"'],
        )
        slider(
            v,
            html,
            "width",
            "{{ surface_control.width }}",
            (
                ("surface_control.from",),
                ("surface_control.to",),
                ("surface_control.step",),
            ),
            told="width.toFixed(3)",
            shown="surface_control.width",
        )
        slider(
            *(v, html, "specular_scale", "β as share of the physical", (0, 3, 0.01)),
            told="specular_scale.toFixed(2) + '  (β ' + beta + ')'",
            shown="surface_control.scale",
        )
        v.VCombobox(
            v_model=("index",),
            items=("['1.3', '1.4', '1.45', '1.5', 'epidermis', 'dermis']",),
            label="refractive index n",
            density="compact",
            variant="outlined",
            hide_details=True,
            classes="my-2",
            v_if="surface_control.n",
            raw_attrs=['data-test="index"'],
        )


def _build_picture(v: Any, html: Any) -> None:
    """Lay out how the picture is made and shown."""
    with group(html, "Picture"):
        slider(
            *(v, html, "stops", "exposure", (-4, 4, 0.1)),
            told="'× ' + (2 ** stops).toPrecision(3)",
        )
        v.VCheckbox(
            v_model=("adapted",),
            label="eyes adapted to the light (CAT16)",
            density="compact",
            hide_details=True,
            raw_attrs=['data-test="adapted"'],
        )
        slider(
            *(v, html, "tolerance_log", "tolerance", (-1, 1.3, 0.05)),
            told="'ΔE00 ' + (10 ** tolerance_log).toPrecision(2)",
        )
        with (
            html.Table(classes="sv-plan", raw_attrs=['data-test="plan"']),
            html.Tbody(),
            html.Tr(v_for="row in plan", key="row.knob"),
        ):
            html.Td("{{ row.knob }}")
            with html.Td():
                html.Div("{{ row.chosen }}")
                html.Div(
                    "left out: {{ row.left_out }}",
                    v_if="row.left_out",
                    classes="sv-left-out",
                )
                html.Div("{{ row.told }}", v_if="row.told", classes="sv-left-out")
        html.Div("{{ note }}", v_for="note in notes", key="note")


def _build_saving(v: Any, html: Any) -> None:
    """Lay out what is kept of the view."""
    with group(html, "Save"):
        v.VTextField(
            v_model=("file_name",),
            label="name, in the opened folder",
            density="compact",
            variant="outlined",
            hide_details=True,
            classes="my-2",
            raw_attrs=['data-test="file_name"'],
        )
        with html.Div(classes="sv-buttons"):
            for text, click in (
                ("figure", "window.skinviz.ask('save_figure', [file_name + '.png'])"),
                ("scene", "window.skinviz.ask('save_scene', [file_name + '.toml'])"),
                (
                    "scene, and copy command",
                    "window.skinviz.copyCommand(file_name + '.toml')",
                ),
            ):
                v.VBtn(
                    text,
                    size="small",
                    variant="outlined",
                    click=click,
                    raw_attrs=[f'data-test="save {text}"'],
                )
        html.Code("{{ command }}", v_if="command", classes="sv-command")
