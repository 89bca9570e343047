"""Spectral rules: at which wavelengths light is computed, and what each adds to XYZ.

A plain sum over bands, the exact sum of every nanometre and line, and few nodes that
integrate skin nearly as well. Choosing those is :mod:`skinviz.spectra.node_choice`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._validate import as_numbers, as_spectra, as_wavelengths
from skinviz.errors import ArgumentError
from skinviz.spectra.colorimetry import colour_matching_functions
from skinviz.spectra.illuminants import Illuminant, as_illuminant
from skinviz.spectra.lines import within
from skinviz.spectra.node_choice import few_nodes
from skinviz.spectra.wavelengths import band_widths

Array = NDArray[np.float64]
Lamp = str | Illuminant

EXACT_LIMITS = (380.0, 780.0)
"""From where to where :func:`exact_rule` sums: what skin's coefficients cover. [nm]"""

_DARK = 1e-290  # luminance over power that a float cannot be divided by


@dataclass(frozen=True, eq=False)
class SpectralRule:
    """Wavelengths, each lamp's light there, and what it adds to XYZ.

    XYZ of a surface of reflectance R(λ) under lamp l, perfect white Y = 1, is
    Σ_j R(λ_j) light[l, j] colour[j].

    Attributes
    ----------
    wavelengths : (J,) ndarray
        Nodes; at each, a lamp has light. Not always ascending, and where lamps have
        nodes of their own, perhaps not all different. [nm]
    light : (L, J) ndarray
        Of each lamp, ≥ 0; scaled so that R = 1 gives Y = 1.
    colour : (J, 3) ndarray
        XYZ of unit light, ≥ 0.
    """

    wavelengths: Array
    light: Array
    colour: Array

    @property
    def weights(self) -> Array:
        """By which reflectance becomes XYZ under each lamp, (L, J, 3)."""
        return np.asarray(self.light[:, :, None] * self.colour)

    @property
    def white(self) -> Array:
        """XYZ of R = 1 under each lamp, (L, 3)."""
        return self.light @ self.colour

    def xyz(self, reflectance: ArrayLike) -> Array:
        """Return XYZ (L, ..., 3) of reflectances (..., J) under each lamp."""
        values = as_spectra(reflectance, self.wavelengths.size, "reflectance")
        return np.stack([values @ weights for weights in self.weights])


def band_rule(
    lamps: Sequence[Lamp] | Lamp, bands: ArrayLike, observer: str = "cie1931"
) -> SpectralRule:
    """Return the plain sum over bands.

    Parameters
    ----------
    lamps : sequence of str or Illuminant
        As for :func:`~skinviz.spectra.illuminants.as_illuminant`.
    bands : (n,) array_like
        Strictly ascending. [nm]
    observer : {"cie1931", "cie1964"}
        2° or 10°.

    Returns
    -------
    rule : SpectralRule
        Its weights are those of :func:`~skinviz.spectra.colorimetry.xyz_weights`;
        bands in which no lamp has power are left out.

    Raises
    ------
    ArgumentError
        If a lamp's table does not cover the bands, it has only lines and none there,
        or gives no light that the observer sees.
    """
    sources, nm = _illuminants(lamps), as_wavelengths(bands)
    colour = colour_matching_functions(nm, observer) * band_widths(nm)[:, None]
    return _lit(nm, np.stack([lamp.spd(nm) for lamp in sources]), colour, sources)


def exact_rule(
    lamps: Sequence[Lamp] | Lamp,
    observer: str = "cie1931",
    limits: tuple[float, float] = EXACT_LIMITS,
) -> SpectralRule:
    """Return the sum over every nanometre of tables, and over lines where they are.

    Parameters
    ----------
    lamps : sequence of str or Illuminant
        As for :func:`~skinviz.spectra.illuminants.as_illuminant`.
    observer : {"cie1931", "cie1964"}
        2° or 10°.
    limits : (first, last)
        Light outside is left out; within 360–830, ascending. [nm]

    Returns
    -------
    rule : SpectralRule
        Wavelengths ascend. A lamp's light is 0 outside its table.

    Raises
    ------
    ArgumentError
        If the limits are none, or a lamp gives no light within them that the
        observer sees.

    Notes
    -----
    Tables are linear between their wavelengths and summed at 1 nm from the first
    limit on. Where a table is finer than that, each node has its mean over the
    nanometre around it, so that nothing falls between nodes; a table of one
    wavelength is a line of 1 nm times its power.
    """
    sources, grid = _illuminants(lamps), _every_nanometre(limits)
    parts = [_nodes(lamp, grid) for lamp in sources]
    nm = np.unique(np.concatenate([wavelengths for wavelengths, _ in parts]))
    power = np.zeros((len(sources), nm.size))
    for row, (wavelengths, own) in zip(power, parts, strict=True):
        np.add.at(row, np.searchsorted(nm, wavelengths), own)
    colour = np.zeros((0, 3))
    if nm.size:
        colour = colour_matching_functions(nm, observer)
    return _lit(nm, power, colour, sources)


def quadrature_rule(
    exact: SpectralRule, reflectances: ArrayLike, n_nodes: int
) -> SpectralRule:
    """Return few nodes whose weighted sums are nearly the exact colours of skin.

    Parameters
    ----------
    exact : SpectralRule
        As :func:`exact_rule` gives it; its wavelengths are those to choose from.
    reflectances : (m, J) array_like
        Spectra like those to be integrated, at the exact rule's wavelengths. [1]
    n_nodes : int
        At most as many for each lamp; lamps of the same spectrum share theirs.

    Returns
    -------
    rule : SpectralRule
        The nodes of one lamp after the other's: ``light`` is 1 on a lamp's own and 0
        elsewhere, ``colour`` its weights. White, R = 1, is kept to rounding. A lamp
        of no more nodes than asked for (of lines) is kept as it is.

    Raises
    ------
    ArgumentError
        If the reflectances are none at these wavelengths, or ``n_nodes`` is not a
        whole number of at least 1.

    Notes
    -----
    Nodes start at equal shares of what is seen and are exchanged one by one, as
    long as it helps, to keep XYZ of the training spectra, of their squares (light
    that bounced once more) and of R = 1 in the least-squares sense of CIELAB;
    weights ≥ 0 come from non-negative least squares [1]_. Real spectra are not the
    model's: smooth deviations of 0.05 and noise of 0.003, rms, count as well, which
    keeps nodes apart that only the model's few pigments would bring together.

    References
    ----------
    .. [1] Lawson & Hanson, Solving Least Squares Problems (1974), chapter 23.
    """
    n = _count(n_nodes)
    spectra = np.atleast_2d(
        as_spectra(reflectances, exact.wavelengths.size, "reflectances")
    )
    if spectra.ndim != 2 or len(spectra) == 0 or np.abs(spectra).max() > 100:
        raise ArgumentError(
            "reflectances must be one or more spectra of about 0 to 1, shape (m, "
            f"{exact.wavelengths.size}); got shape {spectra.shape}"
        )
    rows = [row.tobytes() for row in exact.light]
    first = {row: rows.index(row) for row in rows}
    parts = [_few(exact, exact.light[i], spectra, n) for i in first.values()]
    owner = np.repeat(list(first.values()), [len(nodes) for nodes, _ in parts])
    which = np.array([[first[row]] for row in rows])
    return SpectralRule(
        exact.wavelengths[np.concatenate([nodes for nodes, _ in parts])],
        (owner == which).astype(np.float64),
        np.concatenate([weights for _, weights in parts]),
    )


def _few(
    exact: SpectralRule, light: Array, spectra: Array, n: int
) -> tuple[NDArray[np.intp], Array]:
    """Return nodes (k,) of one lamp's light (J,), and their weights (k, 3)."""
    own = np.flatnonzero(light)
    weights = light[:, None] * exact.colour
    if own.size <= n:
        return own, weights[own]
    return few_nodes(spectra, exact.wavelengths, weights, n)


def _count(n: int) -> int:
    """Return a number of nodes that is one."""
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
        raise ArgumentError(f"n_nodes must be a whole number of at least 1; got {n!r}")
    return int(n)


def _illuminants(lamps: Sequence[Lamp] | Lamp) -> list[Illuminant]:
    """Return the lamps by their names, or as they are; one may be alone."""
    every = [lamps] if isinstance(lamps, str | Illuminant) else lamps
    sources = [as_illuminant(lamp) for lamp in every]
    if not sources:
        raise ArgumentError("a spectral rule needs at least one lamp; got none")
    return sources


def _every_nanometre(limits: tuple[float, float]) -> Array:
    """Return wavelengths (n,) from the first limit to the last. [nm]"""
    ends = as_numbers(limits, "limits")
    if ends.shape != (2,) or not (360 <= ends[0] <= ends[1] <= 830):
        raise ArgumentError(
            "limits must be the first and the last wavelength, within 360 to 830 nm "
            f"where observers see; got {limits!r}"
        )
    count = int(ends[1] - ends[0] + 1e-9) + 1
    return np.asarray(ends[0] + np.arange(count, dtype=np.float64))


def _nodes(lamp: Illuminant, grid: Array) -> tuple[Array, Array]:
    """Return where a lamp has power (k,) [nm], and how much (k,), with each line."""
    lines, table, power = lamp.lines, lamp.wavelengths, np.zeros(grid.size)
    if table.size == 1:
        lines = np.concatenate([lines, [[table[0], lamp.power[0]]]])
    elif lamp.power.any():
        power = _sampled(lamp, grid)
    lines = lines[within(lines, grid[0], grid[-1])]
    return (
        np.concatenate([grid[power > 0], np.clip(lines[:, 0], grid[0], grid[-1])]),
        np.concatenate([power[power > 0], lines[:, 1]]),
    )


def _sampled(lamp: Illuminant, grid: Array) -> Array:
    """Return a table's power over each nanometre (n,); 0 outside the table."""
    nm, power = lamp.wavelengths, lamp.power
    if np.diff(nm).min() >= 1:
        return np.interp(grid, nm, power, left=0.0, right=0.0)
    edges = np.append(grid - 0.5, grid[-1] + 0.5)
    joints = np.union1d(nm, edges)
    heights = np.interp(joints, nm, power / power.max(), left=0.0, right=0.0)
    # Beyond its ends the table is 0 at once, not on a slope.
    inside = (joints[:-1] >= nm[0]) & (joints[1:] <= nm[-1])
    areas = np.where(inside, (heights[:-1] + heights[1:]) / 2 * np.diff(joints), 0.0)
    before = np.append(0.0, np.cumsum(areas))
    return np.asarray(np.diff(before[np.searchsorted(joints, edges)]) * power.max())


def _lit(
    nm: Array, power: Array, colour: Array, lamps: Sequence[Illuminant]
) -> SpectralRule:
    """Return the rule of lamps' powers (L, n): Y of R = 1 is 1, no node is dark."""
    # The largest value first, so that powers of 1e-30 or 1e30 neither vanish nor
    # overflow in the sum.
    largest = power.max(axis=1, initial=0.0, keepdims=True)
    light = power / np.where(largest > 0, largest, 1.0)
    luminance = light @ colour[:, 1]
    if (luminance < _DARK).any():
        blind = lamps[int(np.argmin(luminance))].name
        raise ArgumentError(
            f"illuminant {blind} has no power where the observer sees, among these "
            "wavelengths; choose others or another lamp"
        )
    light /= luminance[:, None]
    lit = light.any(axis=0)
    return SpectralRule(nm[lit], light[:, lit], colour[lit])
