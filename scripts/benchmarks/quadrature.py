"""Measure what few spectral nodes cost in the colours of measured skin.

Every spectrum of the shipped archives, linear between its bands and held at its ends,
is integrated by the exact rule, 380–780 nm; ΔE00 is from that, with the lamp's own
white. Nodes are chosen by the two-layer model's spectra alone, never by the archives;
plain sums are over 400–700 nm. Cells are the largest difference / 99 %.
Run in the development environment: ``python scripts/benchmarks/quadrature.py``.
"""

import numpy as np
from _print import machine, race

from skinviz import load_archive, skin_model
from skinviz.spectra.colorimetry import OBSERVERS, delta_e_2000, xyz_to_lab
from skinviz.spectra.rules import SpectralRule, band_rule, exact_rule, quadrature_rule

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "3000 K")
NODES = (4, 5, 6, 8, 10, 12)
BANDS = (16, 31, 61)
RUNS = 50


def main() -> None:
    """Print the table, with what it was measured on."""
    spectra = measured_skin()
    model = skin_model(site="cheek", specular="included")
    print(f"{len(spectra[0][1])} + {len(spectra[1][1])} spectra of skin; {machine()}\n")
    heads = [*(f"{n} nodes" for n in NODES), *(f"{n} bands" for n in BANDS)]
    print(f"| lamp, observer | {' | '.join(heads)} |")
    print("|---" * (1 + len(heads)) + "|")
    worst = []
    for observer in OBSERVERS:
        for lamp in LAMPS:
            exact = exact_rule(lamp, observer)
            training = model.diffuse(model.starts, exact.wavelengths)
            rules = [
                *(quadrature_rule(exact, training, n) for n in NODES),
                *(band_rule(lamp, np.linspace(400, 700, n), observer) for n in BANDS),
            ]
            worst.append([errors(rule, exact, spectra) for rule in rules])
            print(f"| {lamp}, {observer} | {' | '.join(map(cell, worst[-1]))} |")
    print(f"| worst | {' | '.join(map(cell, np.max(worst, axis=0)))} |\n")
    print(f"Choosing nodes for one lamp, {len(training)} training spectra:")
    times = race(
        {f"{n} nodes": lambda n=n: quadrature_rule(exact, training, n) for n in NODES},
        RUNS,
    )
    print(", ".join(f"{name} {1e3 * time:.1f} ms" for name, time in times.items()))


def measured_skin() -> list[tuple[np.ndarray, np.ndarray]]:
    """Return each archive's bands [nm] and the spectra known on all of them."""
    found = []
    for name in ("issa", "nist"):
        archive = load_archive(name).sel(wavelength=slice(400, 740))
        spectra = archive.reflectance.values
        whole = np.isfinite(spectra).all(axis=1)
        found.append((archive.wavelength.values, spectra[whole]))
    return found


def errors(
    rule: SpectralRule,
    exact: SpectralRule,
    spectra: list[tuple[np.ndarray, np.ndarray]],
) -> tuple[float, float]:
    """Return the largest ΔE00 of a rule over all spectra, and the 99th percentile."""
    white = exact.white[0]
    if white.min() < 0.01 * white[1]:
        white = np.ones(3)
    found = np.concatenate(
        [
            delta_e_2000(*(xyz_to_lab(xyz(r, *part), white) for r in (rule, exact)))
            for part in spectra
        ]
    )
    return float(found.max()), float(np.percentile(found, 99))


def xyz(rule: SpectralRule, bands: np.ndarray, spectra: np.ndarray) -> np.ndarray:
    """Return XYZ of spectra, linear between their bands and held at the ends."""
    unit = np.eye(bands.size)
    between = np.stack([np.interp(rule.wavelengths, bands, row) for row in unit])
    return spectra @ (between @ rule.weights[0])


def cell(error: tuple[float, float]) -> str:
    """Return a cell of the table."""
    return f"{error[0]:.2f} / {error[1]:.2f}"


if __name__ == "__main__":
    main()
