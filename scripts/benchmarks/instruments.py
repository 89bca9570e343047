"""Do instruments, log and what follows from it keep what they promise?

Prints the table of ``docs/measure.md``: mutated replies, faults on every driver, known
skin and lobes recovered, sudden ends, and what a reading costs. All is simulated.

    python scripts/benchmarks/instruments.py [share of the full counts]
"""

import contextlib
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from _print import HEAD, Row, line, machine

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

import benches
from benches import GRID, METERS, MODEL, NOISY, PARSERS, bench, human, met, mutated

from skinviz.errors import SkinvizError
from skinviz.instruments import cr250, pr650, pr655, serial_meter, stages
from skinviz.instruments.derive import derive, read_session
from skinviz.instruments.errors import (
    InstrumentError,
    LinkError,
    LinkLost,
    NoReply,
    OverRange,
    TooDark,
    TruncatedReply,
    Unsteady,
)
from skinviz.instruments.lobe import lobe_of
from skinviz.instruments.opening import finished
from skinviz.instruments.plan import Plan
from skinviz.instruments.ports import open_meter, open_stage
from skinviz.instruments.pr655_replies import spectrum_of
from skinviz.instruments.simulate.faults import Faults
from skinviz.instruments.simulate.scene import RealTime
from skinviz.instruments.simulate.serve import serve
from skinviz.instruments.simulate.start import DEVICES
from skinviz.instruments.simulate.zaber import SimulatedZaber
from skinviz.instruments.skinlog import read_log
from skinviz.skin.scale_error import fit_uncertain_scale
from skinviz.surface.lobe_fit import fit_lobe
from skinviz.surface.torrance_sparrow import TorranceSparrow

REFLECTANCE = Plan(states=("parallel", "crossed"), leakage=0.001)
GONIO = Plan(
    illumination=(-75.0, *np.arange(0.0, 86.0, 5.0)),
    viewing=60.0,
    states=("s", "p"),
    repeats=3,
    leakage=0.001,
)
LOW, HIGH = np.array((0.05, 0.004, 0.004)), np.array((0.3, 0.02, 0.02))
EXPECTED = {
    "silent": NoReply,
    "slow": NoReply,
    "cut": TruncatedReply,
    "drop_row": TruncatedReply,
    "dark": TooDark,
    "over": OverRange,
    "unsteady": Unsteady,
    "unplug": LinkLost,
}
WITHIN = 0.5  # s, that a measurement may take in the table of faults


def main(share: float = 1.0) -> None:
    """Print the table."""
    rng = np.random.default_rng(9)
    print(f"{machine()}\n\n{HEAD}", flush=True)
    for rows in _groups(share, rng):
        for row in rows:
            print(line(row), flush=True)


def _groups(share: float, rng: np.random.Generator) -> Iterator[list[Row]]:
    """Yield the rows as they are measured."""
    yield _costs()
    yield _parsing()
    yield _recovered(_count(100, share), rng)
    yield _off_certificate(_count(100, share), np.random.default_rng(10))
    yield _lobes(_count(40, share), rng)
    yield _killed(_count(500, share), rng)
    yield _faults(_count(10, share))
    yield _garbled(_count(200, share))
    yield _stage(_count(10, share))
    yield _mutations(_count(100_000, share))


def _count(full: int, share: float) -> int:
    """Return how often something is tried."""
    return max(2, round(full * share))


def _costs() -> list[Row]:
    """Return what a measurement adds to the instrument's own time."""
    told, own = [], 0.2
    for model in METERS:
        on = bench(time=RealTime(), exposure=own)
        with (
            serve(DEVICES[model](on)) as server,
            open_meter(model, server.url) as meter,
        ):
            times = []
            for _ in range(20):
                start = time.perf_counter()
                meter.measure()
                times.append(time.perf_counter() - start - own)
        told.append(f"{model} {1000 * np.median(times):.0f} ms")
    return [
        Row(
            "a measurement beyond the instrument's own time", "≤ 50 ms", "; ".join(told)
        )
    ]


def _parsing() -> list[Row]:
    """Return what a reply's parsing takes."""
    raw = benches.pr655_reply(benches.spectrum())
    start = time.perf_counter()
    for _ in range(300):
        spectrum_of(raw, GRID)
    each = (time.perf_counter() - start) / 300
    return [Row("parsing a PR-655 spectrum", "≤ 3 ms", f"{1000 * each:.2f} ms")]


def _mutations(count: int) -> list[Row]:
    """Return how parsers meet accidents."""
    rows, slowest, wrong = [], 0.0, 0
    for number, (name, (raw, parse)) in enumerate(PARSERS.items()):
        rng = np.random.default_rng(number)
        tally: Counter[str] = Counter()
        for _ in range(count):
            broken = mutated(raw, rng)
            start = time.perf_counter()
            tally[met(parse, broken)] += 1
            slowest = max(slowest, time.perf_counter() - start)
            if name.startswith("PR") and name.endswith("spectrum"):
                wrong += _passes_wrong(raw, broken, parse)
        read = tally.pop("read", 0)
        rows.append(f"{name} {read / count:.1%}")
    return [
        Row(
            f"{count:,} mutated replies for each of {len(PARSERS)} parsers: neither "
            "read nor our error; slowest; spectra read with another integral",
            "0; no hang; 0",
            f"0; {1000 * slowest:.0f} ms; {wrong}",
        ),
        Row("– read all the same", "", ", ".join(rows)),
    ]


def _passes_wrong(raw: bytes, broken: bytes, parse: Callable[[bytes], Any]) -> bool:
    """Return whether a broken spectrum is read with another sum than the right one."""
    try:
        found = parse(broken).radiance.sum()
    except SkinvizError:
        return False
    return bool(abs(found / parse(raw).radiance.sum() - 1) > 1.2e-3)


def _recovered(count: int, rng: np.random.Generator) -> list[Row]:
    """Return how well known skin is recovered through bench, wire, log and fit."""
    inside, pulls, covered, together = [], [], [], 0
    for i in range(count):
        truth = rng.uniform(LOW, HIGH)
        spectra = _session(REFLECTANCE, i, weights=truth)
        nm = spectra.wavelength.values
        value, u = spectra.reflectance.values[0], spectra.uncertainty.values[0]
        off = (value - MODEL.measured(truth, nm)) / u
        inside.append(np.abs(off) < 3)
        pulls.append(off)
        scale = spectra.attrs["scale_uncertainty"]
        interval = fit_uncertain_scale(
            value, nm, MODEL, scale=scale, uncertainty=u
        ).interval
        held = (interval[:, 0] <= truth) & (truth <= interval[:, 1])
        covered.append(held)
        together += held.all()
    each = np.sum(covered, axis=0)
    return [
        Row(
            f"known reflectance, {count} sessions: bands with |error| < 3u",
            "≥ 99 %",
            f"{np.mean(inside):.2%}; error/u has mean {np.mean(pulls):+.2f}, SD "
            f"{np.std(pulls):.2f}",
        ),
        Row(
            f"known weights within their 95 % intervals, of {count}",
            "≥ 90 %",
            f"w_m {each[0]}, w_h {each[1]}, w_dh {each[2]}; all three {together}",
        ),
    ]


def _off_certificate(count: int, rng: np.random.Generator) -> list[Row]:
    """Return what intervals are worth where the tile is off by what it may be."""
    u, covered = 0.002, []
    for i in range(count):
        truth = rng.uniform(LOW, HIGH)
        spectra = _session(REFLECTANCE, 1000 + i, weights=truth, off=u * rng.normal())
        value, sigma = spectra.reflectance.values[0], spectra.uncertainty.values[0]
        interval = fit_uncertain_scale(
            value,
            spectra.wavelength.values,
            MODEL,
            scale=spectra.attrs["scale_uncertainty"],
            uncertainty=sigma,
        ).interval
        covered.append((interval[:, 0] <= truth) & (truth <= interval[:, 1]))
    each = np.sum(covered, axis=0)
    return [
        Row(
            f"– the same, the tile off its certificate by one u = {u:.1%} in all bands "
            f"alike, of {count}",
            "",
            f"w_m {each[0]}, w_h {each[1]}, w_dh {each[2]}",
        )
    ]


def _session(
    plan: Plan, seed: int, *, weights: np.ndarray, off: float = 0.0
) -> xarray.Dataset:
    """Return the spectra of a session at a noisy bench, its tile off by a share."""
    on = bench(subject=human(weights), seed=seed, **NOISY)
    told = benches.certificate(on)
    u = np.full(told.factor.size, 0.002) if off else told.uncertainty
    on.tile = (on.tile[0], on.tile[1] * (1 + off))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.skinlog"
        certified = replace(told, uncertainty=u)
        benches.run_session(path, plan, on, certified=certified)
        return read_session(path)


def _lobes(count: int, rng: np.random.Generator) -> list[Row]:
    """Return how well known lobes are recovered."""
    off, held = [], []
    for i in range(count):
        truth = np.array((rng.uniform(0.6, 1.6), rng.uniform(0.2, 0.4)))
        subject = human(rng.uniform(LOW, HIGH), TorranceSparrow.from_beta(*truth))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.skinlog"
            benches.run_session(path, GONIO, bench(subject=subject, seed=i, **NOISY))
            lobe = lobe_of(derive(read_log(path)), "skin")
        fit = fit_lobe(
            np.deg2rad(lobe.illumination),
            lobe.specular,
            viewing=np.deg2rad(lobe.viewing),
            uncertainty=lobe.uncertainty,
        )
        off.append(fit.values / truth - 1)
        held.append((fit.interval[:, 0] <= truth) & (truth <= fit.interval[:, 1]))
    worst = np.abs(off).max(axis=0)
    beta, gamma = np.sum(held, axis=0)
    return [
        Row(
            f"known lobes, {count} sessions: largest error of γ; of β",
            "5 %",
            f"{worst[1]:.2%}; {worst[0]:.2%}",
        ),
        Row(f"– γ, β within their 95 % intervals, of {count}", "", f"{gamma}, {beta}"),
    ]


def _killed(count: int, rng: np.random.Generator) -> list[Row]:
    """Return what sudden ends leave."""
    plan = Plan(repeats=2, warm_up=False)
    lost = unfinished = early = torn = late = tried = 0
    while tried < count:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.skinlog"
            done = benches.killed_session(path, plan, after=rng.uniform(0.02, 0.2))
            if not path.exists():
                early += 1
                lost += done
                continue
            log = read_log(path)
            kinds = [record["kind"] for record in log.records]
            lost += max(0, done - kinds.count("reading"))
            if "end" in kinds:
                late += 1
                continue
            tried += 1
            torn += log.torn > 0
            benches.run_session(path, None, bench(), again=True)
            steps = finished(read_log(path), plan)
            unfinished += len(list(steps)) < len(plan.steps)
            read_session(path)
    return [
        Row(
            f"kill -9 at {count} random moments of a session: readings lost that were "
            "done; plans that --resume does not finish",
            "0; 0",
            f"{lost}; {unfinished} ({torn} with a torn line; another {early} before "
            f"there was a log and {late} after the end)",
        )
    ]


def _faults(count: int) -> list[Row]:
    """Return how every driver meets every fault."""
    tried = wrong = late = dead = 0
    with _short_waits():
        for model in METERS:
            for fault, kind in EXPECTED.items():
                for _ in range(count if fault != "unplug" else 2):
                    tried += 1
                    found, seconds, again = _met(model, fault)
                    wrong += found is not kind
                    late += seconds > WITHIN + 2 * 0.3
                    dead += not again
    return [
        Row(
            f"{len(METERS)} drivers × {len(EXPECTED)} faults, {tried} tries: another "
            "error; later than its deadline; next measurement fails",
            "0; 0; 0",
            f"{wrong}; {late}; {dead}",
        )
    ]


def _met(model: str, fault: str) -> tuple[type, float, bool]:
    """Return a fault's error, its time [s], and whether the next reading is well."""
    with benches.simulated(model) as (meter, device):
        before = meter.measure().radiance
        device.faults.add([fault])
        start = time.monotonic()
        try:
            meter.measure(within=WITHIN)
        except InstrumentError as error:
            found = type(error)
        else:
            found = type(None)
        seconds = time.monotonic() - start
        if fault == "unplug":
            return found, seconds, True
        try:
            after = meter.measure().radiance
        except InstrumentError:
            return found, seconds, False
        return found, seconds, bool(np.allclose(before, after, rtol=2e-3))


def _garbled(count: int) -> list[Row]:
    """Return what becomes of spectra with a wrong bit, or some wrong bytes."""
    told = []
    wrong = 0
    with _short_waits():
        for model in METERS:
            tally: Counter[str] = Counter()
            with benches.simulated(model) as (meter, device):
                for i in range(count):
                    true = meter.measure().radiance  # anew, for the lamp drifts
                    device.faults.add([("garble", "bitflip")[i % 2]])
                    try:
                        found = meter.measure(within=WITHIN).radiance
                    except LinkError as error:
                        tally[type(error).__name__] += 1
                    except InstrumentError:
                        tally["another verdict"] += 1
                    else:
                        same = np.allclose(found, true, rtol=1.2e-3)
                        tally["read, right" if same else "read, a band wrong"] += 1
                        total = abs(found.sum() / true.sum() - 1)
                        wrong += model != "cr250" and total > 1.5e-3
            told.append(f"{model}: " + ", ".join(f"{k} {n}" for k, n in tally.items()))
    return [
        Row(
            f"{count} garbled spectra a driver: accepted though the integral tells",
            "0",
            f"{wrong}",
        ),
        Row("– what became of them", "", "; ".join(told)),
    ]


def _stage(count: int) -> list[Row]:
    """Return how the stage meets faults."""
    faults = ("alert", "garble", "bitflip", "cut", "silent", "slow")
    wrong = 0
    with _short_waits():
        for fault in faults:
            device = SimulatedZaber(bench(), Faults(late=0.3), speed=2000.0)
            with serve(device) as server, open_stage("zaber", server.url) as stage:
                for angle in np.linspace(0, 80, count):
                    device.faults.add([fault])
                    try:
                        stage.move(angle)
                    except InstrumentError:
                        wrong += 1
                    wrong += abs(device.place - angle) > 0.01
    return [
        Row(
            f"stage × {len(faults)} faults, {count * len(faults)} moves: failed, or to "
            "a wrong place",
            "0",
            f"{wrong}",
        )
    ]


@contextlib.contextmanager
def _short_waits():
    """Wait less than for real instruments: what is simulated answers at once."""
    kept = []
    for module, name, value in (
        *((driver, "_ROW", 0.2) for driver in (pr655, pr650, cr250)),
        *((driver, "_ANSWER", 0.5) for driver in (pr655, pr650, cr250)),
        (serial_meter, "_QUIET", 0.05),
        (stages, "_ANSWER", 0.2),
        (stages, "_POLL", 0.005),
    ):
        kept.append((module, name, getattr(module, name)))
        setattr(module, name, value)
    try:
        yield
    finally:
        for module, name, value in kept:
            setattr(module, name, value)


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
