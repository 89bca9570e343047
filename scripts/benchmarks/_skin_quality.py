"""How well three weights, or more, describe real skin, for ``skin_fit.py``."""

import numpy as np
from _print import Row, columns

from skinviz.skin.coefficients import body_sites
from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model, skin_models
from skinviz.spectra.archives import load_archive

GOALS = {"two-layer": "0.0080, each 0.011", "extended": "0.0020, inside its bounds"}


def rows() -> list[Row]:
    """Return the mean sums of squares on ISSA, and the weights' distance to bounds."""
    return [_row(name) for name in skin_models()]


def _row(name: str) -> Row:
    """Return the figure of one model: sites, pooled, statuses."""
    archive = load_archive("issa")
    nm, scaled, status, inside = archive.wavelength.values, {}, [], True
    for site in body_sites():
        model = skin_model(name, site=site, specular="included")
        fit = fit_skin(
            archive.reflectance.values[archive.site.values == site], nm, model
        )
        scaled[site] = fit.sse_61
        status.append(fit.status)
        low, high = zip(*((p.lower, p.upper) for p in model.parameters), strict=True)
        within = (fit.values >= low) & (fit.values <= high)
        inside = inside and bool(within[fit.status != "refused"].all())
    pooled, told = np.concatenate(list(scaled.values())), np.concatenate(status)
    sites = ", ".join(f"{s} {columns(sse.mean(), '.4f')}" for s, sse in scaled.items())
    kinds, numbers = np.unique(told, return_counts=True)
    counts = ", ".join(f"{n} {k}" for k, n in zip(kinds, numbers, strict=True))
    return Row(
        f"mean SSE × 61/31, {name}, {pooled.size:,} ISSA spectra of four sites, "
        "effective table, specular included",
        GOALS.get(name, "–"),
        f"{pooled.mean():.4f}; {sites}; {counts}"
        + ("" if inside else "; OUT OF BOUNDS"),
    )
