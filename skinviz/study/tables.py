"""Tables II and III of the paper, for people of an archive and every skin model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.skin.skin_fit import NOT_CONVERGED, REFUSED
from skinviz.study.people import People

Array = NDArray[np.float64]

SITES = ("cheek", "back of hand", "outer arm", "inner arm")
"""The paper's body sites, in the order of its tables."""

COEFFICIENTS = ("effective", "textbook")
"""The coefficient sets that the tables are made for."""

PAPER_WEIGHTS = {
    "w_m": (454, 384, 276, 234),
    "w_h": (278, 152, 152, 84),
    "w_dh": (50, 222, 170, 264),
}
"""The paper's Table II: weights of subject A at ``SITES``, in the paper's own unit."""

PAPER_ERRORS = {
    "proposed": (0.068, 0.034, 0.049, 0.039),
    "previous": (0.248, 0.123, 0.179, 0.176),
}
"""The paper's Table III: average errors of its three subjects at ``SITES``."""


@dataclass(frozen=True, eq=False)
class Method:
    """One model with one coefficient set, fitted to people.

    Attributes
    ----------
    model, coefficients : str
        Names.
    parameters, units : tuple of str
        Of the model.
    values : (people, sites, p) ndarray
        Estimates; NaN where refused.
    interval : (people, sites, p, 2) ndarray
        95 % intervals.
    sse_61 : (people, sites) ndarray
        Sum of squared differences, scaled to 61 bands.
    status : (people, sites) ndarray of str
        As in :class:`SkinFit`.
    """

    model: str
    coefficients: str
    parameters: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    interval: Array
    sse_61: Array
    status: NDArray[np.str_]

    @property
    def n_failed(self) -> int:
        """How many spectra were refused or did not converge."""
        return int(np.isin(self.status, (REFUSED, NOT_CONVERGED)).sum())

    def parameter(self, name: str) -> Array:
        """Return a parameter's estimates (people, sites)."""
        return np.asarray(self.values[..., self.parameters.index(name)])


def fit_people(people: People, model: str, coefficients: str) -> Method:
    """Fit a skin model to people's spectra, each site with its own thickness.

    Parameters
    ----------
    people : People
        At sites of Table I.
    model : str
        One of :func:`skin_models`.
    coefficients : str
        Name of a coefficient set.
    """
    models = [
        skin_model(
            model, specular=people.specular, site=site, coefficients=coefficients
        )
        for site in people.sites
    ]
    fits = [
        fit_skin(people.reflectance[:, i], people.wavelengths, own)
        for i, own in enumerate(models)
    ]
    return Method(
        model=model,
        coefficients=coefficients,
        parameters=tuple(p.name for p in models[0].parameters),
        units=tuple(p.unit for p in models[0].parameters),
        values=np.stack([fit.values for fit in fits], axis=1),
        interval=np.stack([fit.interval for fit in fits], axis=1),
        sse_61=np.stack([fit.sse_61 for fit in fits], axis=1),
        status=np.stack([fit.status for fit in fits], axis=1),
    )


def order_agreement(values: Array, paper: Sequence[float]) -> Array:
    """Return the share of pairs of sites that stand in the paper's order.

    Parameters
    ----------
    values : (..., sites) ndarray
        A weight; a tie counts half.
    paper : (sites,) sequence of float
        The paper's; its own ties are left out.

    Returns
    -------
    share : (...) ndarray
        1 if the order is the paper's, 0 if it is the reverse, 0.5 by chance; NaN
        where a value is.
    """
    pairs = [
        (i, j) for i, j in combinations(range(len(paper)), 2) if paper[i] != paper[j]
    ]
    signs = [
        np.sign(values[..., i] - values[..., j]) * np.sign(paper[i] - paper[j])
        for i, j in pairs
    ]
    return np.asarray((1 + np.mean(signs, axis=0)) / 2)


@dataclass(frozen=True)
class Duel:
    """How the errors of two methods compare, over people and sites.

    Attributes
    ----------
    first, second : float
        Mean error of each over the spectra that both fitted.
    wins : float
        Share of the spectra that the first fits better.
    n : int
        How many spectra.
    """

    first: float
    second: float
    wins: float
    n: int


def compare(first: Method, second: Method) -> Duel:
    """Return how the errors of two methods on the same people compare."""
    both = np.isfinite(first.sse_61) & np.isfinite(second.sse_61)
    own, other = first.sse_61[both], second.sse_61[both]
    return Duel(
        float(own.mean()), float(other.mean()), float((own < other).mean()), own.size
    )
