"""Comparing the levels of a factor of a study: site, condition, group, subject."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range, one_of
from skinviz.errors import ArgumentError
from skinviz.skin.fit import fit_skin
from skinviz.skin.model import SkinModel
from skinviz.skin.skin_fit import SkinFit
from skinviz.spectra.archive_selection import set_means
from skinviz.study.colour_error import ColourError, colour_error
from skinviz.study.comparison import Cell, Comparison, Stratum
from skinviz.study.contrasts import colour_difference, contrasts_of, corrected
from skinviz.study.quantities import Measured, measure
from skinviz.study.records import without
from skinviz.study.statistics import mean_interval
from skinviz.study.study import FACTORS, Gap, Study

Array = NDArray[np.float64]

MOST_LEVELS = 12
"""Levels of which every pair is compared; of more only the means are given."""


def compare_study(
    study: Study,
    by: str,
    *,
    levels: Sequence[str] = (),
    model: str = "two-layer",
    coefficients: str = "effective",
    seed: int = 0,
    advance: Callable[[int], object] | None = None,
) -> Comparison:
    """Compare the levels of a factor within each site and condition of a study.

    Every spectrum is fitted; repeats of a subject are averaged, and means and tests
    are over subjects. Compared by subject, they are over the subject's repeats.

    Parameters
    ----------
    study : Study
        From :func:`read_study` or :func:`archive_study`.
    by : {"site", "condition", "group", "subject"}
        The factor. The others, site and condition, are the strata.
    levels : sequence of str
        Only these; all if none are named.
    model, coefficients : str
        As for :func:`skin_model`.
    seed : int
        Of the Monte Carlo draws of colours.
    advance : callable, optional
        Told the number of spectra of each part that is fitted.

    Returns
    -------
    comparison : Comparison
        Pairs of levels only if there are at most ``MOST_LEVELS``.

    Raises
    ------
    ArgumentError
        If the factor or a level is unknown, there are fewer than two levels, or the
        seed is negative.

    Notes
    -----
    A pair of levels is compared within subjects (paired t, Cohen's d_z) where most
    subjects of the smaller level have both, else between the subjects that have one
    (Welch's t, Hedges's g). Where these come from several origins, the origin is a
    factor; without an origin that has both levels nothing can be tested. p-values are
    corrected by Holm's method over all that one comparison tests.
    """
    in_range(seed, 0, 2**63 - 1, "seed")
    chosen, unnamed = _chosen(study, by, levels)
    found = measure(chosen, model=model, coefficients=coefficients, advance=advance)
    if by != "site":  # at one site it is w_m by another name
        found = found.less("w_m_depth")
    fitted, refused = _fitted(chosen, found)
    named = [name for name in study.levels(by) if name in fitted.levels(by)]
    groups = _groups(fitted, by, named, found.values[~found.failed])
    bands = fitted.spectra["wavelength"].values
    cells = _cells(groups, bands, found.models, seed)
    pairs: list[tuple[Cell, Cell]] = []
    if len(named) <= MOST_LEVELS:
        for stratum in dict.fromkeys(cell.stratum for cell in cells):
            pairs += combinations([c for c in cells if c.stratum == stratum], 2)
    contrasts = [c for pair in pairs for c in contrasts_of(*pair, by, found.quantities)]
    return Comparison(
        study=fitted,
        by=by,
        levels=tuple(named),
        unit="repeat" if by == "subject" else "subject",
        quantities=found.quantities,
        cells=tuple(cells),
        contrasts=corrected(contrasts),
        colours=tuple(colour_difference(*pair) for pair in pairs),
        gaps=(*study.gaps, *unnamed, *refused),
        model=model,
        coefficients=coefficients,
        seed=seed,
    )


def _chosen(
    study: Study, by: str, levels: Sequence[str]
) -> tuple[Study, tuple[Gap, ...]]:
    """Return the study with the chosen levels, and gaps where no level is told."""
    one_of(by, FACTORS, "factor to compare by")
    known = [level for level in study.levels(by) if level]
    for level in levels:
        one_of(level, known, by)
    wanted = [level for level in known if not levels or level in levels]
    if len(wanted) < 2:
        there = f"{wanted[0]!r} alone" if wanted else "none told"
        raise ArgumentError(
            f"a comparison by {by} needs at least two of them; there is {there}"
        )
    own = study.spectra[by].values.astype(str)
    told, gaps = without(study.spectra, own == "", f"its {by} is not told")
    rows = np.flatnonzero(told[by].isin(wanted).values)
    return dataclasses.replace(study, spectra=told.isel(record=rows)), tuple(gaps)


def _fitted(study: Study, found: Measured) -> tuple[Study, tuple[Gap, ...]]:
    """Return the study's records that were fitted, and gaps for the others."""
    spectra, gaps = without(study.spectra, found.failed, "its fit failed")
    if not spectra.sizes["record"]:
        raise ArgumentError("none of the study's spectra could be fitted")
    return dataclasses.replace(study, spectra=spectra), tuple(gaps)


@dataclass(frozen=True, eq=False)
class _Group:
    """The units of one level within one stratum: what a cell is made of."""

    stratum: Stratum
    level: str
    site: str
    units: tuple[str, ...]
    origins: tuple[str, ...]
    values: Array
    spectra: Array


def _groups(
    study: Study, by: str, levels: Sequence[str], values: Array
) -> list[_Group]:
    """Return the units by stratum and level, both in order."""
    data = study.spectra
    labels = {
        key: list(map(str, data[key].values))
        for key in ("site", "condition", "subject")
    }
    strata = [
        Stratum("" if by == "site" else site, "" if by == "condition" else condition)
        for site, condition in zip(labels["site"], labels["condition"], strict=True)
    ]
    rows: dict[tuple[Stratum, str], list[int]] = {
        (stratum, level): [] for stratum in dict.fromkeys(strata) for level in levels
    }
    for i, key in enumerate(zip(strata, data[by].values.astype(str), strict=True)):
        rows[key].append(i)
    repeats = np.array([f"repeat {number}" for number in data["repeat"].values])
    names = repeats if by == "subject" else np.array(labels["subject"])
    groups = []
    for (stratum, level), own in rows.items():
        if not own:
            continue
        units = tuple(dict.fromkeys(names[own].tolist()))
        which = np.array([units.index(name) for name in names[own]])
        first = np.unique(which, return_index=True)[1]
        groups.append(
            _Group(
                stratum=stratum,
                level=level,
                site=labels["site"][own[0]],
                units=units,
                origins=tuple(map(str, data["origin"].values[own][first])),
                values=set_means(values[own], which, len(units)),
                spectra=set_means(data["reflectance"].values[own], which, len(units)),
            )
        )
    return groups


def _cells(
    groups: Sequence[_Group], bands: Array, models: Mapping[str, SkinModel], seed: int
) -> list[Cell]:
    """Return groups with their means, and the fit and colour of their mean spectra."""
    mean_spectra = np.stack(
        [
            set_means(group.spectra, np.zeros(len(group.units), dtype=np.int64), 1)[0]
            for group in groups
        ]
    )
    fits: dict[int, tuple[SkinFit, ColourError]] = {}
    for site, model in models.items():
        rows = [i for i, group in enumerate(groups) if group.site == site]
        if not rows:
            continue
        fit = fit_skin(mean_spectra[rows], bands, model)
        # A seed for each site: equal draws would make colours err alike.
        own = np.random.SeedSequence([seed, rows[0]]).generate_state(1)
        colour = colour_error(fit, seed=int(own[0]))
        for k, row in enumerate(rows):
            one = ColourError(colour.lab[k], colour.samples[k])
            fits[row] = (fit[k], one)
    return [
        Cell(
            stratum=group.stratum,
            level=group.level,
            site=group.site,
            units=group.units,
            origins=group.origins,
            values=group.values,
            means=tuple(mean_interval(column) for column in group.values.T),
            spectra=group.spectra,
            mean_spectrum=mean_spectra[i],
            fit=fits[i][0],
            colour=fits[i][1],
        )
        for i, group in enumerate(groups)
    ]
