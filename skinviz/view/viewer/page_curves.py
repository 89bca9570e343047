"""The right side of the page: numbers at marked points, and curves."""

from __future__ import annotations

from typing import Any

_CHARTS = (
    ("reflectance", "Reflectance of the skin: {{ skin_name }}"),
    ("radiance", "Radiance at the marked points"),
    ("illuminant", "Light"),
)


def build_curves(html: Any) -> None:
    """Lay out the right side."""
    from trame.widgets import plotly

    with html.Aside(classes="sv-curves"):
        _build_points(html)
        for name, title in _CHARTS:
            with html.Section(
                classes="sv-chart", raw_attrs=[f'data-test="{name}_chart"']
            ):
                html.Div(title, classes="sv-chart-title")
                html.Div(
                    "Click the hand to mark a point and see the light that it sends.",
                    v_if=f"{name}_chart.data.length === 0",
                    classes="sv-empty",
                )
                with html.Div(v_if=f"{name}_chart.data.length > 0", classes="sv-plot"):
                    plotly.Figure(
                        state_variable_name=f"{name}_chart",
                        display_mode_bar=False,
                        responsive=True,
                    )


def _build_points(html: Any) -> None:
    """Lay out the marked points' colours."""
    with (
        html.Table(
            classes="sv-points", v_if="points.length", raw_attrs=['data-test="points"']
        ),
        html.Tbody(),
    ):
        with html.Tr(v_for="point in points", key="point.name"):
            with html.Td():
                html.B("{{ point.name }}")
            with html.Template(v_if="point.seen"):
                with html.Td():
                    html.Span(
                        classes="sv-swatch",
                        style=("`background: ${point.hex}`",),
                        raw_attrs=[':title="point.hex"'],
                    )
                html.Td("sRGB {{ point.rgb.join(' ') }}")
                html.Td(
                    "L* {{ point.lab[0] }}  a* {{ point.lab[1] }}  "
                    "b* {{ point.lab[2] }}"
                )
            html.Td("out of sight", v_if="!point.seen", colspan="3")
        with html.Tr(v_if="point_difference !== null"):
            html.Td(
                "ΔE00 between A and B: {{ point_difference?.toFixed(2) }}",
                colspan="4",
                raw_attrs=['data-test="difference"'],
            )
