"""Measure what a table of a model's light costs and how far it is off.

Run in the development environment: ``python scripts/benchmarks/table.py``. Each time
is the shortest of several; the model's own stands beside it, from the same run.
"""

from dataclasses import dataclass

import numpy as np
from _print import machine, on_one_core, race

from skinviz import skin_model
from skinviz.skin.model import SkinModel
from skinviz.skin.table import ReflectanceTable, reflectance_table
from skinviz.spectra.colorimetry import delta_e_2000, xyz_to_lab, xyz_weights
from skinviz.spectra.illuminants import illuminant_spd

POINTS = 200_000
RUNS = 15
TOLERANCES = (3e-3, 1e-3, 3e-4, 1e-4, 1e-5)
BANDS = (8, 61, 401)
SITE = {"site": "back of hand", "specular": "included"}
HEAD = (
    "| what | tolerance | build | nodes | float64 | float32 | error stated | error "
    "found | ΔE00: 99 %, largest |\n|---|---|---|---|---|---|---|---|---|"
)


@dataclass(frozen=True)
class Case:
    """A box of a model's parameters, and how many lamps' XYZ a table holds."""

    name: str
    model: SkinModel
    low: tuple[float, ...]
    high: tuple[float, ...]
    lamps: tuple[str, ...] = ("D65",)


TWO_LAYER = skin_model("two-layer", **SITE)
USUAL = ((0.0, 0.0, 0.0), (0.4, 0.03, 0.02))
CASES = (
    Case("usual skin", TWO_LAYER, *USUAL),
    Case("two lamps", TWO_LAYER, *USUAL, ("D65", "A")),
    Case("one hand", TWO_LAYER, (0.05, 2e-3, 1e-3), (0.4, 0.03, 0.02)),
    Case("up to 1e12", TWO_LAYER, (0.0,) * 3, (1e12,) * 3),
    Case(
        "usual skin, scattering free",
        skin_model("extended", free=("scattering",), **SITE),
        (*USUAL[0], 0.7),
        (*USUAL[1], 1.5),
    ),
)


def main() -> None:
    """Print the model's time, then a row a table."""
    print(f"{machine()}\n\nThe two-layer model and its XYZ, one core:\n")
    print("| bands | ns a point |\n|---|---|")
    for bands in BANDS:
        print(f"| {bands} | {model_time(bands):.0f} |", flush=True)
    print(f"\nTables of XYZ on 8 bands, look-ups in ns a point on one core:\n\n{HEAD}")
    for case in CASES:
        for tolerance in TOLERANCES:
            print(row(case, tolerance), flush=True)


def weights(bands: int, lamps: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return wavelengths and the weights of each lamp's XYZ side by side."""
    nm = np.linspace(430, 670, bands) if bands == 8 else np.linspace(380, 780, bands)
    each = [xyz_weights(nm, illuminant_spd(lamp, nm)) for lamp in lamps]
    return nm, np.concatenate(each, axis=1)


def drawn(case: Case) -> np.ndarray:
    """Return points of the box, half even, half closer to its low corner."""
    low, high = np.array(case.low), np.array(case.high)
    x = np.random.default_rng(1).uniform(size=(POINTS, low.size))
    x[::2] = 10 ** ((-17 if high.max() > 1e3 else -4) * x[::2])
    return np.clip(low + (high - low) * x, low, high)


def model_time(bands: int) -> float:
    """Return the time of one point of the model. [ns]"""
    values = drawn(CASES[0])[:20_000]
    nm, factors = weights(bands, ("D65",))
    alone = on_one_core(lambda: TWO_LAYER.diffuse(values, nm) @ factors)
    return 1e9 * race({"model": alone}, RUNS)["model"] / len(values)


def row(case: Case, tolerance: float) -> str:
    """Return a line of the table of tables."""
    nm, factors = weights(8, case.lamps)
    box = (case.model, case.low, case.high, nm, factors)

    def build(dtype: type = np.float64) -> ReflectanceTable:
        return reflectance_table(*box, tolerance=tolerance, dtype=dtype)

    values = drawn(case)
    fine, coarse = build(), build(np.float32)
    room = [
        np.zeros((POINTS, factors.shape[1]), t.entries.dtype) for t in (fine, coarse)
    ]
    took = race(
        {
            "build": build,
            "float64": on_one_core(lambda: fine.at(values, room[0])),
            "float32": on_one_core(lambda: coarse.at(values, room[1])),
        },
        RUNS if fine.size < 20_000 else 3,
    )
    exact = case.model.diffuse(values, nm) @ factors
    apart = np.abs(fine.at(values) - exact).max()
    colours = colour_difference(fine.at(values), exact, factors)
    ns = {name: 1e9 * took[name] / POINTS for name in ("float64", "float32")}
    return (
        f"| {case.name} | {tolerance:g} | {1e3 * took['build']:.1f} ms | "
        f"{fine.size:,} | {ns['float64']:.0f} | {ns['float32']:.0f} | "
        f"{fine.error.max():.1e} | {apart:.1e} | {np.percentile(colours, 99):.4f}, "
        f"{colours.max():.4f} |"
    )


def colour_difference(
    found: np.ndarray, exact: np.ndarray, factors: np.ndarray
) -> np.ndarray:
    """Return ΔE00 under each lamp, the perfect diffuser as white."""
    white = factors.sum(axis=0).reshape(-1, 3)
    both = (xyz_to_lab(x.reshape(len(x), -1, 3), white) for x in (found, exact))
    return delta_e_2000(*both)


if __name__ == "__main__":
    main()
