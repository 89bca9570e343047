"""What the left side of the page is built of."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any


def group(html: Any, title: str) -> AbstractContextManager[Any]:
    """Begin a group of controls."""
    fields = html.Fieldset(classes="sv-group")
    with fields:
        html.Legend(title, classes="sv-legend")
    return fields  # type: ignore[no-any-return]


def slider(
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


def select(v: Any, name: str, label: str, items: str, **more: Any) -> None:
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
