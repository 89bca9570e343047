"""How pigment weights depend on the coefficient table and on the layers' thickness.

The tables of ``coefficients.py`` that take typical spectra of the ISSA archive, and
the order into which two tables put its people.
"""

from dataclasses import replace

import numpy as np

from skinviz.skin.coefficients import body_sites, layer_thickness
from skinviz.skin.fit import SkinFit, fit_skin
from skinviz.skin.formulas import EffectiveNumbers, effective_coefficients
from skinviz.skin.priors import NAMES, literature
from skinviz.skin.two_layer import TwoLayer
from skinviz.spectra.archives import load_archive


def markdown(header: list[str], rows: list[list[str]]) -> str:
    """Return a table as markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def typical() -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return each site's median spectrum, band by band, duplicates left out."""
    archive = load_archive("issa")
    bands = archive.wavelength.values
    visible = (bands >= 400) & (bands <= 700)
    spectra = archive.reflectance.values[:, visible]
    good = np.isfinite(spectra).all(axis=1) & ~archive.duplicate.values
    sites = archive.site.values
    medians = {
        site: np.median(spectra[good & (sites == site)], axis=0)
        for site in body_sites()
    }
    return medians, bands[visible]


def fitted(
    spectrum: np.ndarray,
    bands: np.ndarray,
    depth: tuple[float, float],
    numbers: EffectiveNumbers,
) -> SkinFit:
    """Return the fit of one or more spectra with a table, specular included."""
    table = effective_coefficients(numbers)
    return fit_skin(spectrum, bands, TwoLayer(depth, table, "included"))


def weights_table(numbers: EffectiveNumbers) -> str:
    """Return what the typical spectra hold with the shipped table."""
    medians, bands = typical()
    rows = []
    for site, spectrum in medians.items():
        depth = layer_thickness(site)
        fit = fitted(spectrum, bands, depth, numbers)
        w_m, w_h, w_dh = fit.values
        low, high = fit.oxygen_saturation_interval
        rows.append(
            [
                *(site, f"{depth[0]:.3f}", f"{w_m:.4f}", f"{w_m * depth[0] * 1e3:.2f}"),
                *(f"{w_h:.5f}", f"{w_dh:.5f}", f"{fit.blood_fraction:.5f}"),
                f"{fit.oxygen_saturation:.2f} ({low:.2f}–{high:.2f})",
            ]
        )
    header = ["site", "D_e [mm]", "w_m", "w_m · D_e [µm]", "w_h", "w_dh", "blood"]
    return markdown([*header, "saturation (95 %)"], rows)


def sensitivity_table(numbers: EffectiveNumbers) -> str:
    """Return how weights move with each number, at each site."""
    medians, bands = typical()
    priors = literature()
    rows = []
    for i, name in enumerate(NAMES):
        value = getattr(numbers, name)
        steps = {"+10 %": value * 1.1, "−10 %": value * 0.9}
        for sign in (1, -1):
            moved = priors.coordinates(numbers)
            moved[i] += sign * priors.deviation[i]
            steps["+1 prior s.d." if sign > 0 else "−1 prior s.d."] = getattr(
                priors.numbers(moved), name
            )
        for label, new in steps.items():
            changed = replace(numbers, **{name: new})
            cells = [
                _moved((spectrum, bands), site, numbers, changed)
                for site, spectrum in medians.items()
            ]
            what = f"{name.replace('_', ' ')} {label} ({new:.2f})"
            rows.append([what, *(_cell(cell) for cell in cells)])
    return markdown(["number moved", *medians], rows)


def thickness_table(numbers: EffectiveNumbers) -> str:
    """Return how weights move with the thickness of each layer by 20 %."""
    medians, bands = typical()
    rows = []
    for layer, name in enumerate(("epidermis", "dermis")):
        for label, factor in (("+20 %", 1.2), ("−20 %", 0.8)):
            cells = []
            for site, spectrum in medians.items():
                depth = list(layer_thickness(site))
                depth[layer] *= factor
                cell = _moved(
                    (spectrum, bands), site, numbers, numbers, depth=tuple(depth)
                )
                product = (1 + cell[0]) * (factor if layer == 0 else 1) - 1
                cells.append(f"{_cell(cell)}; w_m · D_e {product:+.1%}")
            rows.append([f"{name} {label}", *cells])
    return markdown(["thickness", *medians], rows)


def ranks_table(shipped: EffectiveNumbers, other: EffectiveNumbers) -> str:
    """Return whether two tables put people into the same order, at each site."""
    from scipy.stats import spearmanr

    archive = load_archive("issa")
    bands = archive.wavelength.values
    rows = []
    for site in body_sites():
        chosen = (archive.site.values == site) & ~archive.duplicate.values
        spectra = archive.reflectance.values[chosen]
        depth = layer_thickness(site)
        one, two = (fitted(spectra, bands, depth, each) for each in (shipped, other))
        blood = (one.blood_fraction, two.blood_fraction)
        both = (blood[0] > 0) & (blood[1] > 0)
        pairs = {
            "w_m": (one.values[:, 0], two.values[:, 0]),
            "blood": blood,
            "saturation": (
                one.oxygen_saturation[both],
                two.oxygen_saturation[both],
            ),
        }
        cells = []
        for name, (a, b) in pairs.items():
            size = (
                f"{np.median(b) - np.median(a):+.2f}"
                if name == "saturation"
                else f"× {np.median(b) / np.median(a):.2f}"
            )
            cells.append(f"{spearmanr(a, b).statistic:.3f} ({size})")
        empty = (one.values[:, 1] == 0, two.values[:, 1] == 0)
        rows.append(
            [site, str(int(chosen.sum())), *cells]
            + [f"{share.mean():.0%} → {empty[1].mean():.0%}" for share in empty[:1]]
        )
    header = ["site", "spectra", "w_m", "blood", "saturation", "w_h = 0"]
    return markdown(header, rows)


def _moved(
    typical_spectrum: tuple[np.ndarray, np.ndarray],
    site: str,
    before: EffectiveNumbers,
    after: EffectiveNumbers,
    *,
    depth: tuple[float, float] | None = None,
) -> np.ndarray:
    """Return the relative moves of w_m, w_h, w_dh, blood, and that of saturation."""
    spectrum, bands = typical_spectrum
    own = layer_thickness(site)
    first = fitted(spectrum, bands, own, before)
    second = fitted(spectrum, bands, depth or own, after)
    pairs = [*zip(first.values, second.values, strict=True)]
    pairs.append((first.blood_fraction, second.blood_fraction))
    moves = [b / a - 1 if a > 0 else np.nan for a, b in pairs]
    return np.array([*moves, second.oxygen_saturation - first.oxygen_saturation])


def _cell(moves: np.ndarray) -> str:
    """Return the five moves as one cell."""
    relative = " / ".join(
        "–" if np.isnan(move) else f"{100 * move:+.0f}" for move in moves[:4]
    )
    return f"{relative} / {moves[4]:+.2f}"
