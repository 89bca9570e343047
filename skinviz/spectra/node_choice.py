"""Few wavelengths that stand for many: the numerics of a spectral quadrature.

Arrays in, arrays out; what they mean to lamps and observers is said in
:mod:`skinviz.spectra.rules`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_DEVIATION = 0.05  # rms by which real spectra may differ from those trained on
_SMOOTH = 15.0  # nm over which such differences stay alike
_WAVES = 24  # cosines that make them up
_CANDIDATES = 130  # columns to choose from, evenly taken
_RANK = 40  # rows that stand for all spectra
_BLOCK = 40  # spectra at once: BLAS waits for threads that more would start
_WHITE = 10.0  # weight of R = 1 beside all else; scaling makes it exact then
_NOISE = 0.003  # of each wavelength by itself, rms
_EXCHANGES = 4  # a node, at most
_ENOUGH = 1e-3  # of what a node holds, that an exchange has to bring

# XYZ over the white's to L*, a*, b* of skin, over ΔE00's lengths of L* and chroma.
_SEEN = np.array([[0.0, 2.8, 0.0], [1.16, -2.8, 1.25], [0.0, 0.0, -1.75]])


def few_nodes(
    reflectances: Array, wavelengths: Array, weights: Array, n: int
) -> tuple[NDArray[np.intp], Array]:
    """Return at most ``n`` of the wavelengths, and weights that do what all do.

    Parameters
    ----------
    reflectances : (m, J) ndarray
        What is to be integrated, and its squares: light that bounced twice.
    wavelengths : (J,) ndarray
        [nm]
    weights : (J, 3) ndarray
        ≥ 0. Wavelengths at which all are 0 are not chosen.
    n : int
        At least 1.

    Returns
    -------
    nodes : (k,) ndarray of int
        Ascending.
    found : (k, 3) ndarray of float64
        ≥ 0; each channel has the sum of its weights, so that R = 1 is kept.
    """
    from scipy.optimize import nnls

    white = weights.sum(axis=0)
    shares = weights / np.where(white > 0, white, 1.0)
    some = _candidates(weights, n)
    n = min(n, some.size)
    rows = _compressed(_lessons(reflectances, wavelengths, shares, some))
    rows, goal = rows[:, :-3], rows[:, -3:]
    density = np.cumsum(np.abs(shares @ _SEEN).sum(axis=1))[some]
    places = density[-1] * (np.arange(n) + 0.5) / n
    nodes = _exchanged(rows, goal @ _SEEN, _distinct(density, places))
    noisy = np.concatenate([rows[:, nodes], _NOISE * np.eye(n)])
    goal = np.concatenate([goal, np.zeros((n, 3))])
    found = np.stack([nnls(noisy, g)[0] for g in goal.T], axis=1)
    sums = found.sum(axis=0)
    found *= white / np.where(sums > 0, sums, 1.0)
    order = np.argsort(nodes)
    order = order[found[order].any(axis=1)]
    return some[nodes[order]], found[order]


def _candidates(weights: Array, n: int) -> NDArray[np.intp]:
    """Return wavelengths to choose from: those that count, or evenly some of them."""
    own = np.flatnonzero(weights.any(axis=1))
    step = max(1, own.size // max(n, _CANDIDATES))
    return own[(own.size - 1) % step // 2 :: step]


def _lessons(
    reflectances: Array, wavelengths: Array, shares: Array, some: NDArray[np.intp]
) -> Array:
    """Return spectra (k, c + 3): at some wavelengths, and their three integrals.

    The reflectances and their squares, each over its luminance to the 2/3 as CIELAB
    sees differences, and smooth deviations from them.
    """
    squares = reflectances * reflectances
    lessons = []
    for spectra in (reflectances, squares):
        colours = np.concatenate([part @ shares for part in _blocks(spectra)])
        grey = np.maximum(np.abs(colours[:, 1:2]), 1e-3) ** (-2 / 3)
        grey /= np.sqrt(2 * len(spectra))
        lessons.append(grey * np.concatenate([spectra[:, some], colours], axis=1))
    waves = _deviations(wavelengths)
    lessons.append(np.concatenate([waves[:, some], waves @ shares], axis=1))
    return np.concatenate(lessons)


def _blocks(spectra: Array) -> list[Array]:
    """Return spectra (k, n), some at a time."""
    return [spectra[i : i + _BLOCK] for i in range(0, len(spectra), _BLOCK)]


def _deviations(wavelengths: Array) -> Array:
    """Return cosines (k, n) whose random sums are smooth spectra of a known rms."""
    span = max(np.ptp(wavelengths), 1.0)
    turns = np.pi * np.arange(_WAVES)[:, None] / span
    height = np.exp(-0.5 * (turns * _SMOOTH) ** 2)
    height *= _DEVIATION * np.sqrt(2) / np.linalg.norm(height)
    return np.asarray(height * np.cos(turns * (wavelengths - wavelengths.min())))


def _compressed(lessons: Array) -> Array:
    """Return few rows (r, c) with nearly the same sums of squares, and one of R = 1.

    For any w, |rows · w|² is |lessons · w|² but for what the smallest singular values
    add: a random sketch finds the space of the others.
    """
    # A fixed draw: the same spectra have the same nodes each time.
    draw = np.random.default_rng(0).random((len(lessons), _RANK)) - 0.5
    parts = _blocks(lessons)
    seen = sum(d.T @ x for d, x in zip(_blocks(draw), parts, strict=True))
    basis = np.linalg.qr(np.asarray(seen).T)[0]
    inside = [part @ basis for part in parts]
    squares = np.asarray(sum(part.T @ part for part in inside))
    squares += 1e-14 * squares.trace() * np.eye(len(squares))
    rows = (basis @ np.linalg.cholesky(squares)).T
    return np.concatenate([rows, np.full((1, lessons.shape[1]), _WHITE)])


def _distinct(density: Array, places: Array) -> NDArray[np.intp]:
    """Return columns at places of the ascending density, no two the same."""
    nodes = np.unique(np.searchsorted(density, places))
    free = np.setdiff1d(np.arange(density.size), nodes)
    more = np.linspace(0, free.size - 1, places.size - nodes.size).round()
    return np.sort(np.concatenate([nodes, free[more.astype(np.intp)]]))


def _exchanged(rows: Array, goal: Array, nodes: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return columns that leave little of the goal (r, 3), by least squares.

    As long as it helps, the one column gives way whose exchange for another takes
    most away. With q an orthonormal basis of the n columns, d of unit length in
    their span and across all but one, g what the n leave of the goal t: column c in
    that one's place takes away |c·g + (c·d)(d·t)|²/(|c|² − |qᵀc|² + (c·d)²).
    """
    nodes, noise = nodes.copy(), _NOISE * np.eye(nodes.size)
    square = np.einsum("ij,ij->j", rows, rows) + _NOISE**2
    for _ in range(_EXCHANGES * nodes.size):
        basis, corner = np.linalg.qr(np.concatenate([rows[:, nodes], noise]))
        basis, across = basis[: len(rows)], np.linalg.inv(corner)
        across /= np.linalg.norm(across, axis=1)[:, None]
        along, reached = basis.T @ rows, basis.T @ goal
        left = rows.T @ (goal - basis @ reached)
        own, part = across @ along, across @ reached
        held = (part * part).sum(axis=1)[:, None]
        taken = (left * left).sum(axis=1) + 2 * own * (part @ left.T) + own**2 * held
        taken /= square - np.einsum("ij,ij->j", along, along) + own**2
        taken[:, nodes] = 0.0
        gain = taken - held
        out, new = np.unravel_index(np.argmax(gain), gain.shape)
        if gain[out, new] <= _ENOUGH * held[out, 0]:
            break
        nodes[out] = new
    return nodes
