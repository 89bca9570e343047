"""What a comparison of a study's levels finds: means, differences, colours."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinviz.skin.skin_fit import NOT_CONVERGED, REFUSED, SkinFit
from skinviz.study.colour_error import ColourError
from skinviz.study.quantities import Quantity
from skinviz.study.statistics import Difference, Mean
from skinviz.study.study import Gap, Study

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stratum:
    """Within which levels are compared: a site, a condition, both or neither ("")."""

    site: str
    condition: str

    def __str__(self) -> str:
        """Return it in words."""
        return ", ".join(filter(None, (self.site, self.condition))) or "all"


@dataclass(frozen=True, eq=False)
class Cell:
    """One level within one stratum.

    Attributes
    ----------
    stratum : Stratum
        Where.
    level : str
        Of the factor.
    site : str
        Where its spectra were measured.
    units : tuple of str
        What was averaged: subjects, or the repeats of one.
    origins : tuple of str
        Of each unit.
    values : (units, q) ndarray
        Each unit's quantities, the mean of its repeats.
    means : tuple of Mean
        Of each quantity over the units.
    spectra : (units, n) ndarray
        Each unit's mean spectrum. [1]
    mean_spectrum : (n,) ndarray
        The mean of these. [1]
    fit : SkinFit
        Of the mean spectrum.
    colour : ColourError
        Of that fit.
    """

    stratum: Stratum
    level: str
    site: str
    units: tuple[str, ...]
    origins: tuple[str, ...]
    values: Array
    means: tuple[Mean, ...]
    spectra: Array
    mean_spectrum: Array
    fit: SkinFit
    colour: ColourError

    @property
    def is_fitted(self) -> bool:
        """Whether the fit of the mean spectrum came to an end."""
        return str(self.fit.status) not in (REFUSED, NOT_CONVERGED)


@dataclass(frozen=True)
class Contrast:
    """A quantity at two levels within one stratum.

    Attributes
    ----------
    stratum : Stratum
        Where.
    first, second : str
        The levels.
    quantity : Quantity
        What differs.
    difference : Difference
        By how much, with what test.
    p_holm : float or None
        p, corrected for all that a comparison tests.
    """

    stratum: Stratum
    first: str
    second: str
    quantity: Quantity
    difference: Difference
    p_holm: float | None = None


@dataclass(frozen=True)
class ColourDifference:
    """How far apart the colours of two levels' mean spectra are.

    Attributes
    ----------
    stratum : Stratum
        Where.
    first, second : str
        The levels.
    delta_e : float
        ΔE00 of the mean spectra as measured.
    fitted : float
        ΔE00 of the fits to them.
    low, high : float
        95 % interval of ``fitted`` that the covariances of both fits allow; NaN if
        there is no fit.
    """

    stratum: Stratum
    first: str
    second: str
    delta_e: float
    fitted: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """The levels of a factor, stratum by stratum.

    Attributes
    ----------
    study : Study
        What was compared.
    by : str
        The factor.
    levels : tuple of str
        In the study's order.
    unit : str
        What means are taken over: "subject" or "repeat".
    quantities : tuple of Quantity
        What was compared.
    cells : tuple of Cell
        Of each stratum and level that has spectra.
    contrasts : tuple of Contrast
        Of each pair of levels and quantity.
    colours : tuple of ColourDifference
        Of each pair of levels.
    gaps : tuple of Gap
        The study's, and spectra that could not be fitted.
    model, coefficients : str
        What was fitted.
    seed : int
        Of the Monte Carlo draws.
    """

    study: Study
    by: str
    levels: tuple[str, ...]
    unit: str
    quantities: tuple[Quantity, ...]
    cells: tuple[Cell, ...]
    contrasts: tuple[Contrast, ...]
    colours: tuple[ColourDifference, ...]
    gaps: tuple[Gap, ...]
    model: str
    coefficients: str
    seed: int

    @property
    def strata(self) -> tuple[Stratum, ...]:
        """The strata, in the study's order."""
        return tuple(dict.fromkeys(cell.stratum for cell in self.cells))

    def require_whole(self) -> None:
        """Raise if anything is missing, was left out or was changed.

        Raises
        ------
        DataError
            Says how many gaps there are, and the first.
        """
        replace(self.study, gaps=self.gaps).raise_for_gaps()

    def row(self, stratum: Stratum) -> tuple[Cell, ...]:
        """Return the cells of one stratum."""
        return tuple(cell for cell in self.cells if cell.stratum == stratum)
