"""What ``skinviz measure`` measures with: instruments on ports, or simulated ones."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinviz import __version__
from skinviz._validate import one_of
from skinviz.cli.measure_hands import Asking
from skinviz.errors import ArgumentError
from skinviz.instruments.certificate import Certificate, read_certificate
from skinviz.instruments.opening import begin, resume
from skinviz.instruments.plan import Plan
from skinviz.instruments.plan_file import read_plan
from skinviz.instruments.ports import STAGES, open_meter, open_stage, port_of
from skinviz.instruments.serial_meter import SerialMeter
from skinviz.instruments.serial_ports import list_ports
from skinviz.instruments.session import Hands
from skinviz.instruments.simulate.hands import SimulatedHands
from skinviz.instruments.simulate.scene import Bench, QuickTime, RealTime, Subject
from skinviz.instruments.simulate.start import is_simulated, model_of, start, takes_time
from skinviz.instruments.skinlog import read_log
from skinviz.instruments.stages import ManualStage, RotationStage

if TYPE_CHECKING:
    from skinviz.cli.measure_screen import Screen

_USUAL, _STAGE, _AUTO = "pr655", "zaber", "auto"
# What a simulated instrument looks at unless a scene file says it.
_WEIGHTS, _SITE = (0.12, 0.006, 0.004), "back of hand"
_TILE, _U_TILE = 0.985, 0.002


@dataclass(frozen=True)
class Wanted:
    """What the verb was told."""

    log: Path
    port: str | None
    meter: str | None
    stage: str | None
    zero: float
    home: bool
    plan: Path | None
    white: Path | None
    subject: str | None
    site: tuple[str, ...]
    resume: bool
    simulate: Path | None
    seed: int
    yes: bool

    @property
    def idle(self) -> list[str]:
        """Options that say nothing without a port."""
        told = ("meter", "stage", "plan", "white", "subject", "site", "resume")
        names = (*told, "simulate", "yes", "home")
        return [f"--{name}" for name in names if getattr(self, name)]


@dataclass(frozen=True, eq=False)
class World:
    """Where the verb measures: at real ports, or at a simulated bench.

    Attributes
    ----------
    meter : SerialMeter
    stage : RotationStage
    hands : Hands
    certificate : Certificate
        Of the white tile.
    clock : callable
        Seconds, from whenever.
    pause : callable or None
        Lets seconds pass; waits if None.
    """

    meter: SerialMeter
    stage: RotationStage
    hands: Hands
    certificate: Certificate
    clock: Callable[[], float]
    pause: Callable[[float], object] | None


def measured(wanted: Wanted, screen: Screen) -> None:
    """Measure what is wanted, shown on a screen.

    Raises
    ------
    SkinvizError
        If options contradict each other, or measuring ends early.
    """
    port = _port(wanted)
    simulated = is_simulated(port)
    _require_one_world(wanted, simulated=simulated)
    plan, white = _plan(wanted)
    with ExitStack() as ends:
        made = _simulated_world if simulated else _real_world
        world = made(wanted, port, white, screen, ends)
        name, meter = str(wanted.log), world.meter
        session = (
            resume(name, meter, clock=world.clock)
            if wanted.resume
            else begin(
                name,
                plan,
                world.certificate,
                meter,
                clock=world.clock,
                written_by=f"skinviz {__version__}",
            )
        )
        with session.log:
            session.run(meter, world.stage, world.hands, screen, pause=world.pause)


def _port(wanted: Wanted) -> str:
    """Return the meter's port."""
    if wanted.port == _AUTO:
        return port_of(wanted.meter or _USUAL, list_ports())
    return str(wanted.port)


def _require_one_world(wanted: Wanted, *, simulated: bool) -> None:
    """Refuse what is for simulated instruments at real ones, and the reverse."""
    for name in ("simulate", "yes"):
        if getattr(wanted, name) and not simulated:
            raise ArgumentError(
                f"--{name} is for simulated instruments; at a real one say what was "
                "arranged, step by step"
            )
    if wanted.stage is not None and is_simulated(wanted.stage) != simulated:
        raise ArgumentError(
            "a simulated stage turns a simulated lamp; let --port and --stage both be "
            "simulated, or none"
        )
    if wanted.stage is not None and simulated:
        one_of(model_of(wanted.stage), STAGES, "simulated stage")
    if wanted.resume and (wanted.plan or wanted.white or wanted.subject or wanted.site):
        raise ArgumentError(
            "the log has the plan, the white, subject and sites; leave them out with "
            "--resume"
        )


def _plan(wanted: Wanted) -> tuple[Plan, Path | None]:
    """Return the plan and the white's certificate that the options say."""
    plan, white = (Plan(), None) if wanted.plan is None else read_plan(wanted.plan)
    if wanted.subject is not None:
        plan = replace(plan, subject=wanted.subject)
    if wanted.site:
        plan = replace(plan, sites=wanted.site)
    return plan, white if wanted.white is None else wanted.white


def _real_world(
    wanted: Wanted, port: str, white: Path | None, screen: Screen, ends: ExitStack
) -> World:
    """Return instruments at ports."""
    certificate = _certificate(wanted, white)
    if certificate is None:
        raise ArgumentError(
            "name the certificate of the white tile with --white: without it the "
            "reflectance would be relative to a tile that nobody knows"
        )
    hands = Asking(screen.ask, None, turns=wanted.stage is None)
    meter = ends.enter_context(open_meter(wanted.meter or _USUAL, port))
    stage: RotationStage = ManualStage(hands.turn)
    if wanted.stage is not None:
        stage = _homed(ends, wanted, wanted.stage)
    return World(meter, stage, hands, certificate, time.monotonic, None)


def _simulated_world(
    wanted: Wanted, port: str, white: Path | None, screen: Screen, ends: ExitStack
) -> World:
    """Return simulated instruments at a bench of their own."""
    certificate = _certificate(wanted, white) or _simulated_tile()
    bench = Bench(
        _subject(wanted.simulate),
        (certificate.wavelengths, certificate.factor),
        seed=wanted.seed,
        time=RealTime() if takes_time(port) else QuickTime(),
    )
    simulated = SimulatedHands(bench, 0.0 if takes_time(port) else 5.0)
    hands = (
        simulated
        if wanted.yes
        else Asking(screen.ask, simulated, turns=wanted.stage is None)
    )
    served = ends.enter_context(start(port, bench))
    meter = ends.enter_context(open_meter(model_of(port), served.url, pauses=0))
    stage: RotationStage = ManualStage(hands.turn)
    if wanted.stage is not None:
        behind = ends.enter_context(start(wanted.stage, bench))
        stage = _homed(ends, wanted, behind.url)
    return World(meter, stage, hands, certificate, bench.time.now, bench.time.elapse)


def _certificate(wanted: Wanted, white: Path | None) -> Certificate | None:
    """Return the white's certificate: the log's, or the file's if one is named."""
    if wanted.resume:
        return Certificate.from_json(read_log(wanted.log).header["certificate"])
    return None if white is None else read_certificate(white)


def _homed(ends: ExitStack, wanted: Wanted, url: str) -> RotationStage:
    """Return a motorised stage, homed if that is wanted."""
    stage = ends.enter_context(open_stage(_STAGE, url, zero=wanted.zero))
    if wanted.home:
        stage.home()
    return stage


def _subject(scene: Path | None) -> Subject:
    """Return the skin that a simulated instrument looks at, as arrays."""
    from skinviz.skin.models import skin_model
    from skinviz.surface.lobe_curve import in_plane
    from skinviz.surface.models import surface_model

    if scene is None:
        model = skin_model(site=_SITE, specular="excluded")
        values, surface = np.array(_WEIGHTS), surface_model("torrance-sparrow")
    else:
        from skinviz.scene.scene_file import read_scene

        described = read_scene(scene)
        model, values = described.skin.model, described.skin.values
        surface = described.surface
        if values.ndim != 1:
            raise ArgumentError(f"{scene}: its skin differs over the mesh; give one")
    nm = np.arange(380.0, 781.0)
    light, view = np.arange(-85.0, 86.0), np.arange(0.0, 86.0)
    lobe = in_plane(surface, np.deg2rad(light)[:, np.newaxis], np.deg2rad(view))
    n = getattr(surface, "n", 1.4)
    index = float(n) if isinstance(n, int | float) else 1.4
    return Subject(nm, model.reflectance(values, nm), light, view, lobe, index)


def _simulated_tile() -> Certificate:
    """Return the certificate of the simulated white tile."""
    nm = np.array([360.0, 800.0])
    factor, u = np.full(2, _TILE), np.full(2, _U_TILE)
    return Certificate(nm, factor, u, "simulated tile", "")
