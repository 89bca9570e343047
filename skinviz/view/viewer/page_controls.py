"""The left side of the page: everything that can be set."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from skinviz.view.viewer.variables import MOST_WEIGHTS


def build_controls(v: Any, html: Any) -> None:
    """Lay out the left side."""
    with html.Nav(classes="sv-controls", raw_attrs=['aria-label="Controls"']):
        _build_hands(v, html)
        _build_skin(v, html)
        _build_light(v, html)
        _build_view(v, html)
        _build_surface(v, html)
        _build_picture(v, html)
        _build_saving(v, html)


def _group(html: Any, title: str) -> AbstractContextManager[Any]:
    """Begin a group of controls."""
    group = html.Fieldset(classes="sv-group")
    with group:
        html.Legend(title, classes="sv-legend")
    return group  # type: ignore[no-any-return]


def _slider(
    v: Any,
    html: Any,
    name: str,
    label: str,
    limits: tuple[Any, Any, Any],
    *,
    told: str,
    shown: str | None = None,
) -> None:
    """Lay out a slider with its label and value above it.

    ``limits`` are least, most and step, numbers or expressions in parentheses.
    """
    options = {} if shown is None else {"v_if": shown}
    with html.Div(**options):
        with html.Div(classes="sv-row"):
            html.Span(label, classes="sv-label")
            html.Span(f"{{{{ {told} }}}}", classes="sv-value")
        low, high, step = limits
        v.VSlider(
            v_model=(name,),
            min=low,
            max=high,
            step=step,
            density="compact",
            hide_details=True,
            thumb_size=14,
            track_size=3,
            color="primary",
            raw_attrs=[f'data-test="{name}" aria-label="{name}"'],
        )


def _select(v: Any, name: str, label: str, items: str, **more: Any) -> None:
    """Lay out a list to choose from."""
    kind = v.VAutocomplete if more.pop("searched", False) else v.VSelect
    kind(
        v_model=(name,),
        items=(items,),
        label=label,
        density="compact",
        variant="outlined",
        hide_details=True,
        classes="my-2",
        raw_attrs=[f'data-test="{name}"'],
        **more,
    )


def _build_hands(v: Any, html: Any) -> None:
    """Lay out how many hands are shown and whose skin they have."""
    with _group(html, "Hands"):
        with html.Div(classes="sv-row"):
            with v.VBtnToggle(
                v_model=("hands",),
                mandatory=True,
                density="compact",
                variant="outlined",
                divided=True,
                raw_attrs=['data-test="hands" aria-label="how many hands"'],
            ):
                for n in (1, 2, 4):
                    v.VBtn(str(n), value=(str(n),), size="small")
            v.VCheckbox(
                v_model=("difference",),
                label="ΔE00 map",
                density="compact",
                hide_details=True,
                disabled=("hands !== 2",),
                raw_attrs=['data-test="difference_map"'],
            )
        with html.Div(v_if="hands > 1", classes="sv-row"):
            html.Span("controls set hand")
            with v.VBtnToggle(
                v_model=("active",),
                mandatory=True,
                density="compact",
                variant="outlined",
                divided=True,
                raw_attrs=['data-test="active"'],
            ):
                v.VBtn(
                    "{{ n }}",
                    v_for="n in hands",
                    key="n",
                    value=("n - 1",),
                    size="x-small",
                )
        _select(v, "group", "group", "groups", clearable=True)
        _select(
            v,
            "person",
            "subject",
            "people",
            clearable=True,
            searched=True,
            placeholder="the scene's own",
            persistent_placeholder=True,
        )
        _select(v, "site", "body site", "sites", disabled=("!person",))


def _build_skin(v: Any, html: Any) -> None:
    """Lay out the skin's parameters."""
    with _group(html, "Skin"):
        for k in range(MOST_WEIGHTS):
            with html.Div(v_if=f"weights.length > {k}"):
                _slider(
                    v,
                    html,
                    f"weight_{k}",
                    f"{{{{ weights[{k}]?.label }}}}",
                    (
                        (f"weights[{k}]?.from || 0",),
                        (f"weights[{k}]?.to || 1",),
                        (f"weights[{k}]?.step || 0.001",),
                    ),
                    told=f"weight_{k}?.toFixed(4)",
                )
                with html.Div(
                    v_if=f"weights[{k}]?.high > 0",
                    classes="sv-range",
                    raw_attrs=[f':title="weights[{k}]?.told"'],
                ):
                    html.Div(
                        style=(
                            f"`left: ${{100 * weights[{k}].low}}%; width: ${{100 * "
                            f"(weights[{k}].high - weights[{k}].low)}}%`",
                        )
                    )
        _slider(
            v,
            html,
            "saturation",
            "oxygen saturation",
            (0, 1, 0.01),
            told="saturation?.toFixed(2)",
            shown="saturation !== null",
        )
        with html.Div(classes="sv-buttons"):
            v.VBtn(
                "as fitted",
                size="small",
                variant="outlined",
                disabled=("!skin_changed",),
                click="window.skinviz.ask('fitted')",
                raw_attrs=['title="Green: 95 % interval of the fit"'],
            )


def _build_light(v: Any, html: Any) -> None:
    """Lay out the light."""
    with _group(html, "Light"):
        _select(v, "illuminant", "illuminant", "lamps")
        _slider(
            *(v, html, "light_angle", "angle", (-90, 90, 1)),
            told="light_angle.toFixed(0) + '°'",
        )
        _slider(
            *(v, html, "light_tilt", "tilt", (-90, 90, 1)),
            told="light_tilt.toFixed(0) + '°'",
        )


def _build_view(v: Any, html: Any) -> None:
    """Lay out the viewer's place."""
    with _group(html, "View"):
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
        _slider(
            *(v, html, "view_angle", "angle", (-180, 180, 1)),
            told="view_angle.toFixed(0) + '°'",
        )
        _slider(
            *(v, html, "view_tilt", "tilt", (-90, 90, 1)),
            told="view_tilt.toFixed(0) + '°'",
        )


def _build_surface(v: Any, html: Any) -> None:
    """Lay out the surface."""
    with _group(html, "Surface"):
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
        _slider(
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
        _slider(
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
    with _group(html, "Picture"):
        _slider(
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
        _slider(
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
    with _group(html, "Save"):
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
