"""Spectra for ``skin_fit.py``: real ones on the paper's grid, and simulated ones."""

from dataclasses import dataclass

import numpy as np

from skinviz.skin.coefficients import body_sites
from skinviz.skin.model import SkinModel
from skinviz.skin.models import skin_model
from skinviz.spectra.archives import load_archive
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS

NM = PAPER_WAVELENGTHS
NOISE = 1e-3  # of one band of a real spectrometer
HARD = {
    "dark": ((0.3, 0.0, 0.0), (0.8, 0.05, 0.05), 2e-3),
    "black": ((0.8, 0.0, 0.0), (2.0, 0.05, 0.05), 2e-3),
    "bloodless": ((0.02, 0.0, 0.0), (0.5, 3e-4, 3e-4), 2e-3),
    "pale": ((0.0, 0.0, 0.0), (0.02, 0.02, 0.02), 2e-3),
    "noisy": ((0.0, 0.0, 0.0), (0.5, 0.03, 0.03), 3e-2),
}
"""Weights from and to, and the noise of a band, of spectra that are hard to fit.

Black is darker than people are: the noise exceeds what melanin lets through. Where
little is known, as there and in the noisy ones, there are several minima.
"""


@dataclass(frozen=True, eq=False)
class Batch:
    """Spectra (m, 61) and the model they are to be fitted with."""

    name: str
    model: SkinModel
    spectra: np.ndarray


def real(seed: int = 1) -> list[Batch]:
    """Return ISSA's spectra of each site at 61 bands, linearly between its 31.

    A little noise takes away that every second band follows from its neighbours.
    """
    archive, rng = load_archive("issa"), np.random.default_rng(seed)
    nm, batches = archive.wavelength.values, []
    for site in body_sites():
        measured = archive.reflectance.values[archive.site.values == site]
        fine = np.array([np.interp(NM, nm, spectrum) for spectrum in measured])
        batches.append(
            Batch(
                site,
                skin_model(site=site, specular="included"),
                _noisy(rng, fine, NOISE),
            )
        )
    return batches


def repeated(batch: Batch, m: int, seed: int = 2) -> Batch:
    """Return m spectra like those of a batch: the same, each with its own noise."""
    rng = np.random.default_rng(seed)
    spectra = np.resize(batch.spectra, (m, batch.spectra.shape[1]))
    return Batch(batch.name, batch.model, _noisy(rng, spectra, NOISE))


def simulated(m: int, noise: float = 2e-3, seed: int = 3) -> Batch:
    """Return m skins of evenly drawn weights with noise, on the back of the hand."""
    return _drawn("simulated", ((0.02, 0.0, 0.0), (0.4, 0.03, 0.02), noise), m, seed)


def hard(m: int) -> list[Batch]:
    """Return m spectra of each kind that is hard to fit."""
    return [
        _drawn(name, kind, m, seed)
        for seed, (name, kind) in enumerate(HARD.items(), start=10)
    ]


def _drawn(name: str, kind: tuple, m: int, seed: int) -> Batch:
    """Return spectra of evenly drawn weights; a kind is as in ``HARD``."""
    low, high, noise = kind
    rng = np.random.default_rng(seed)
    model = skin_model(site="back of hand", specular="included")
    clean = model.measured(rng.uniform(low, high, (m, 3)), NM)
    return Batch(name, model, _noisy(rng, clean, noise))


def _noisy(rng: np.random.Generator, spectra: np.ndarray, sigma: float) -> np.ndarray:
    """Return spectra with noise; a reading below 0 is 0, as an instrument has it."""
    return np.maximum(spectra + rng.normal(0, sigma, spectra.shape), 0)
