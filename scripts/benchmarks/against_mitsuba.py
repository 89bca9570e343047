"""Show a hand by skinviz and by Mitsuba 3 side by side: colours, time against error.

The same mesh, normals, far light, parallel view and 61 bands of D65; direct light and
cast shadows only. First a Lambertian surface of a fitted skin's reflectance, then half
of it and half of rough facets (Beckmann, Smith), which both programs state exactly.
ΔE00 on linear XYZ, white the perfect diffuser, over lit pixels of which all 16 of our
samples hit the hand; Mitsuba's scale is that of its own picture of a perfect diffuser.

Prints markdown tables; ``--out`` keeps pictures. Run in the development environment
and, for Mitsuba's fast variant, a libLLVM that works
(Debian: libllvm19): ``python scripts/benchmarks/against_mitsuba.py --out compared``;
``--quick`` for a first look in a minute or two.
"""

import argparse
from pathlib import Path

import _mitsuba_variant
import numpy as np
from _print import HEAD, Row, busy, line, machine

SWEEP = (1, 4, 16, 64, 256, 1024, 4096)
SHORT = 256  # samples to which the Lambertian's sweep goes: its goal is the colours
SPECTRAL_SIZE = 256  # Mitsuba's film of 61 bands is slow
GOALS = {"Lambertian": "mean 0.3", "half rough": "–"}


def main() -> None:
    """Print the comparison, material by material."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--size", type=int, default=512, help="of the picture [pixels]")
    parser.add_argument("--angles", default="30/0", help="light's and view's [deg]")
    parser.add_argument("--out", type=Path, help="folder for pictures")
    parser.add_argument("--variant", choices=(
        _mitsuba_variant.COMPILED, _mitsuba_variant.PLAIN))  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="256 pixels, 256 samples")
    parser.add_argument("--only", choices=GOALS, help="one material")
    asked = parser.parse_args()
    variant = _mitsuba_variant.choose(asked.variant)
    print(f"{machine()}; {_mitsuba_variant.describe(variant)}\n")
    size = 256 if asked.quick else asked.size
    sweep = [spp for spp in SWEEP if spp <= 256 or not asked.quick]
    names = [asked.only] if asked.only else list(GOALS)
    compare(asked.angles, size, sweep, names=names, out=asked.out)
    print(f"\nAt the end: {busy()}")


def compare(
    angles: str, size: int, sweep: list[int], *, names: list[str], out: Path | None
) -> None:
    """Check Mitsuba against the formulas, then race it on each material."""
    # They import Mitsuba's variant, which must have been chosen.
    import _mitsuba_bands
    import _mitsuba_checks
    import _mitsuba_race
    from _mitsuba_setting import as_material, as_setting, scenes

    from skinviz.rendering.geometry import geometry_of

    ours = scenes(angles, size)
    geometry = geometry_of(next(iter(ours.values())).mesh)
    setting = as_setting(next(iter(ours.values())), geometry)
    materials = {name: as_material(scene) for name, scene in ours.items()}
    print(f"{size} × {size} pixels, {angles}\n\n{HEAD}", flush=True)
    for row in _mitsuba_checks.rows(setting, materials, ours["half rough"].surface):
        print(line(row), flush=True)
    for name in names:
        own = [spp for spp in sweep if spp <= SHORT or name != "Lambertian"]
        race = _mitsuba_race.run(
            ours[name], geometry, setting, materials[name], spps=own, best=sweep[-1]
        )
        for row in agreement(name, race):
            print(line(row), flush=True)
        print(f"\n{table(name, race)}\n\n{HEAD}", flush=True)
        for row in ratios(name, race):
            print(line(row), flush=True)
        if out:
            draw(name, race, angles, out)
    small = scenes(angles, min(size, SPECTRAL_SIZE))["half rough"]
    setting = as_setting(small, geometry)
    for row in _mitsuba_bands.rows(small, geometry, setting, materials["half rough"]):
        print(line(row), flush=True)


def agreement(name: str, race) -> list[Row]:
    """Return how far the two programs' best pictures are apart."""
    from _mitsuba_error import difference

    spp = 2 * race.spp
    return [
        Row(f"{name}: skinviz, 16 samples, to Mitsuba, {spp} samples; ΔE00 mean / 99 % "
            f"/ largest over {race.inside.sum()} pixels", GOALS[name],
            str(difference(race.map))),
        Row(f"{name}: – pixels that are over 1 ΔE00 apart", "–",
            f"{(race.map > 1).sum() / race.inside.sum():.2%}"),
        Row(f"{name}: – noise of Mitsuba's picture itself, mean ΔE00", "–",
            f"{race.noise:.3f}"),
    ]  # fmt: skip


def table(name: str, race) -> str:
    """Return every picture's time and error."""
    rows = [
        f"| {name}, by | samples | time [ms] | ΔE00 mean / 99 % / largest | noise |",
        "|---|---|---|---|---|",
    ]
    for who, points in race.curves.items():
        for p in points:
            noise = f"{p.noise:.3f}" if p.noise else "–"
            rows.append(
                f"| {who} | {p.samples} | {1e3 * p.seconds:.1f} | {p.error} | {noise} |"
            )
    return "\n".join(rows)


def ratios(name: str, race) -> list[Row]:
    """Return how much longer Mitsuba takes to each of our errors."""
    from _mitsuba_error import seconds_to

    ours = race.curves["skinviz"]
    return [
        Row(f"{name}: time of {who}, to our {what} ΔE00 at "
            f"{', '.join(str(p.samples) for p in ours)} samples, over ours",
            "50 ×" if name == "half rough" else "–",
            ", ".join(times(seconds_to(getattr(p.error, part), points, part), p)
                      for p in ours))
        for who, points in race.curves.items() if who != "skinviz"
        for part, what in (("mean", "mean"), ("high", "99 %"))
    ]  # fmt: skip


def times(found: tuple[float, str], point) -> str:
    """Return a ratio of times as text."""
    seconds, sign = found
    return f"{sign}{seconds / point.seconds:.3g} ×"


def draw(name: str, race, angles: str, out: Path) -> None:
    """Write the pictures of a material."""
    import _mitsuba_figure

    stem = name.replace(" ", "_").lower()
    mean = np.nanmean(race.map)
    _mitsuba_figure.draw_maps(
        race.picture, race.reference, race.map,
        f"{name}, D65, {angles}: mean ΔE00 {mean:.3f}", out / f"{stem}_map.png",
    )  # fmt: skip
    _mitsuba_figure.draw_race(race.curves, out / f"{stem}_race.png")


if __name__ == "__main__":
    main()
