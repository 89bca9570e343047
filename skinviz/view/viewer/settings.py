"""What browsers set: each of the page's variables checked, then a new state."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from skinviz._validate import in_range
from skinviz.view.viewer.answering import checked
from skinviz.view.viewer.controls import (
    CONTROLS,
    with_saturation,
    with_surface,
    with_weight,
)
from skinviz.view.viewer.samples import ANY_GROUP
from skinviz.view.viewer.variables import MOST_WEIGHTS

if TYPE_CHECKING:
    from skinviz.view.viewer.app import Viewer


def listen_to_settings(viewer: Viewer, server: Any) -> None:
    """Turn to a new state when a browser sets one of the page's variables."""
    for name in CONTROLS:
        server.state.change(name)(_on_control(viewer, name))
    for k in range(MOST_WEIGHTS):
        server.state.change(f"weight_{k}")(_on_weight(viewer, k))
    server.state.change("saturation")(_on_saturation(viewer))
    server.state.change("surface")(_on_surface(viewer))
    server.state.change("person")(_on_person(viewer))
    server.state.change("site")(_on_site(viewer))
    server.state.change("group")(_on_group(viewer))


def _on_control(viewer: Viewer, name: str) -> Callable[..., None]:
    """Return what sets the state by one of the page's variables."""
    read, write = CONTROLS[name]

    def changed(**variables: Any) -> None:
        value = variables[name]
        if value is None or read(viewer.state) == value:
            return
        checked(viewer, lambda v: v.change(lambda state: write(state, value)))()

    return changed


def _on_weight(viewer: Viewer, k: int) -> Callable[..., None]:
    """Return what sets one of the active hand's parameters."""

    def changed(**variables: Any) -> None:
        value, shown = variables[f"weight_{k}"], viewer.shown
        if value is None or shown is None:
            return
        sample = viewer.sample()
        if k < len(sample.skin.model.parameters):
            checked(
                viewer,
                lambda v: v.change(lambda state: with_weight(state, sample, k, value)),
            )()

    return changed


def _on_saturation(viewer: Viewer) -> Callable[..., None]:
    """Return what sets the active hand's oxygen saturation."""

    def changed(saturation: Any, **_: Any) -> None:
        if saturation is None or viewer.shown is None:
            return
        share = in_range(saturation, 0.0, 1.0, "saturation")
        sample = viewer.sample()
        viewer.change(lambda state: with_saturation(state, sample, share))

    return lambda **variables: checked(viewer, lambda _: changed(**variables))()


def _on_surface(viewer: Viewer) -> Callable[..., None]:
    """Return what sets the surface model."""

    def changed(surface: Any, **_: Any) -> None:
        if isinstance(surface, str):
            viewer.change(lambda state: with_surface(state, viewer.opened, surface))

    return changed


def _on_group(viewer: Viewer) -> Callable[..., None]:
    """Return what lists the people of a group."""

    def changed(group: Any, **_: Any) -> None:
        viewer.list_people(group if isinstance(group, str) else ANY_GROUP)

    return changed


def _on_person(viewer: Viewer) -> Callable[..., None]:
    """Return what gives the active hand another person's skin."""

    def changed(person: Any, **_: Any) -> None:
        name = person or ""
        if name == viewer.state.look.person:
            return
        sites = viewer.opened.samples.sites(name) if name else []
        if not name:
            viewer.change(lambda state: state.with_look(person="", site="", weights=()))
        elif sites:
            old = viewer.state.look.site or viewer.own_site()
            site = old if old in sites else sites[0]
            viewer.change(
                lambda state: state.with_look(person=name, site=site, weights=())
            )
        else:
            viewer.refuse(f"nobody is called {str(name)[:60]!r}; choose from the list")

    return lambda **variables: checked(viewer, lambda _: changed(**variables))()


def _on_site(viewer: Viewer) -> Callable[..., None]:
    """Return what gives the active hand the skin of another site."""

    def changed(site: Any, **_: Any) -> None:
        look = viewer.state.look
        if site and look.person and site != look.site:
            viewer.change(lambda state: state.with_look(site=site, weights=()))

    return lambda **variables: checked(viewer, lambda _: changed(**variables))()
