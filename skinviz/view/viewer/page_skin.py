"""The upper left of the page: whose skin is shown, and what of it is set."""

from __future__ import annotations

from typing import Any

from skinviz.view.viewer.page_parts import group, select, slider
from skinviz.view.viewer.variables import MOST_WEIGHTS


def build_hands(v: Any, html: Any) -> None:
    """Lay out how many hands are shown and whose skin they have."""
    with group(html, "Hands"):
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
        select(v, "group", "group", "groups", clearable=True)
        select(
            v,
            "person",
            "subject",
            "people",
            clearable=True,
            searched=True,
            placeholder=("skin_name",),
            persistent_placeholder=True,
        )
        select(v, "site", "body site", "sites", disabled=("!person",))


def build_skin(v: Any, html: Any) -> None:
    """Lay out the skin's parameters."""
    with group(html, "Skin"):
        for k in range(MOST_WEIGHTS):
            with html.Div(v_if=f"weights.length > {k}"):
                slider(
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
        slider(
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
