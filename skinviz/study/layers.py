"""The thickness of skin at the body sites of a study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, DataError
from skinviz.skin.coefficients import body_sites, layer_thickness
from skinviz.study.records import without
from skinviz.study.study import Gap

if TYPE_CHECKING:
    import xarray


def layers_of(
    sites: list[str], told: Mapping[str, Mapping[str, Any]]
) -> dict[str, tuple[float, float]]:
    """Return the thickness of each site's layers, of those that have one. [mm]

    Parameters
    ----------
    sites : list of str
        Names.
    told : mapping of str to mapping
        For some sites ``thickness``, two numbers in mm, or ``like``, a site of
        Table I; the others are looked up by their own names.

    Raises
    ------
    DataError
        If what is told of a site is wrong.
    """
    for name, table in told.items():
        if len(table) != 1 or table.keys() - {"thickness", "like"}:
            raise DataError(
                f"[sites.{name!r}] needs thickness = [epidermis, dermis] in mm or like "
                f"= a site of {', '.join(body_sites())}"
            )
    found = {}
    for name in sites:
        own = told.get(name, {"like": name} if name in body_sites() else {})
        if "like" in own:
            found[name] = layer_thickness(str(own["like"]))
        elif "thickness" in own:
            found[name] = _two_depths(own["thickness"], name)
    return found


def with_layers(
    spectra: xarray.Dataset, told: Mapping[str, Mapping[str, Any]]
) -> tuple[xarray.Dataset, dict[str, tuple[float, float]], list[Gap]]:
    """Return the spectra of sites whose layers are known, these, and the gaps."""
    layers = layers_of(list(dict.fromkeys(spectra["site"].values)), told)
    unknown = ~spectra["site"].isin(list(layers)).values
    why = (
        f"the thickness of its skin is not known, Table I has {', '.join(body_sites())}"
        "; say which of these it is like"
    )
    kept, gaps = without(spectra, unknown, why)
    if not kept.sizes["record"]:
        raise DataError(f"no record can be used: of no site {why}")
    return kept, layers, gaps


def _two_depths(told: Any, site: str) -> tuple[float, float]:
    """Return a told thickness as two numbers above 0. [mm]"""
    if not isinstance(told, list | tuple) or len(told) != 2:
        raise DataError(f"thickness of {site!r} must be [epidermis, dermis] in mm")
    try:
        epidermis, dermis = (in_range(d, 1e-4, 100, "thickness", "mm") for d in told)
    except ArgumentError as error:
        raise DataError(f"{site}: {error}") from error
    return epidermis, dermis
