"""``skinviz measure``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.cli.arguments import Whole
from skinviz.cli.output import say, say_files, say_json

if TYPE_CHECKING:
    from skinviz.cli.measure_bench import Wanted


def measure(
    log: Path | None = None,
    /,
    *,
    port: str | None = None,
    meter: str | None = None,
    stage: str | None = None,
    zero: float = 0.0,
    home: bool = False,
    plan: Path | None = None,
    white: Path | None = None,
    subject: str | None = None,
    site: tuple[str, ...] = (),
    resume: bool = False,
    export: tuple[Path, ...] = (),
    gonio: Path | None = None,
    simulate: Path | None = None,
    seed: Whole = 0,
    yes: bool = False,
    list: bool = False,
    json: bool = False,
) -> None:
    """Measure skin with a spectroradiometer, step by step, or read a session's log.

    Every reading is in the log, on the disk, before the next is taken. Without --port
    nothing is measured, and what was asked for is made of the log.

    Example: skinviz measure hand.skinlog --port sim://pr655 --yes --export hand.nc

    Parameters
    ----------
    log
        The session's log to write or to read, .skinlog; a new one is named by date and
        time if not said.
    port
        Port of the spectroradiometer, as /dev/ttyACM0, socket://host:4001, or
        sim://pr655 for a simulated one (also pr670, pr650, cr250); auto for the one
        port whose description names the meter.
    meter
        Its model: pr655, pr670, pr650, cr250, cr300; not needed for a simulated one.
    stage
        Port of a Zaber stage that turns the lamp, or sim://zaber; by hand if not said.
    zero
        Angle of the stage in degrees at which the lamp stands over the normal.
    home
        Find the stage's reference position first. It moves.
    plan
        What to measure, a TOML file; 45/0 without polarisers if not said.
    white
        Certificate of the white tile: CSV of wavelength_nm, factor, uncertainty.
    subject
        Pseudonym of the subject, instead of the plan's.
    site
        Body site, once for each, instead of the plan's.
    resume
        Go on with a session that was interrupted.
    export
        Reflectance to write, once for each file: .nc (everything), .csv, .tsv, .spdx,
        .cgats.
    gonio
        Specular part by angle to write, .csv, with the lobe fitted to it.
    simulate
        Scene file whose skin and surface a simulated instrument looks at.
    seed
        Of a simulated instrument's noise.
    yes
        Take every arrangement of a simulated bench as made, and do not ask.
    list
        List the serial ports. Nothing is sent to any of them.
    json
        Print what was done as JSON.
    """
    from skinviz.cli.measure_bench import Wanted
    from skinviz.errors import ArgumentError

    if list:
        _list_ports(json)
        return
    if log is None and (port is None or resume):
        raise ArgumentError("name the session's log, as hand.skinlog, or say --list")
    own = _named_by_time() if log is None else log
    wanted = Wanted(
        own, port, meter, stage, zero, home, plan, white, subject, site, resume,
        simulate, seed, yes,
    )  # fmt: skip
    _require_outputs(own, export, gonio)
    if port is not None:
        _measure(wanted, quiet=json)
    elif wanted.idle:
        raise ArgumentError(
            f"{', '.join(wanted.idle)} is for measuring; say --port, or leave it out"
        )
    _conclude(own, export, gonio, json=json)


def _named_by_time() -> Path:
    """Return the name of a new log, by the moment."""
    from datetime import datetime

    return Path(f"{datetime.now().astimezone():%Y%m%d-%H%M%S}.skinlog")


def _list_ports(json: bool) -> None:
    """Print the ports."""
    import dataclasses

    from skinviz.cli.text_table import Column, table
    from skinviz.instruments.serial_ports import list_ports
    from skinviz.instruments.simulate.start import DEVICES, SCHEME

    ports = list_ports()
    simulated = [SCHEME + name for name in DEVICES]
    if json:
        found = [dataclasses.asdict(port) for port in ports]
        say_json({"ports": found, "simulated": simulated})
        return
    if ports:
        columns = [
            Column("USB", [port.usb or "-" for port in ports]),
            Column("serial number", [port.serial or "-" for port in ports]),
            Column("description", [port.description or "-" for port in ports]),
        ]
        for line in table("port", [port.name for port in ports], columns):
            say(line)
    else:
        say("no serial ports; check the cable, or use a simulated instrument")
    say(f"simulated: {', '.join(simulated)}")


def _require_outputs(log: Path, export: Sequence[Path], gonio: Path | None) -> None:
    """Refuse, before hours of measuring, what could not be written in the end."""
    from skinviz._validate import one_of
    from skinviz.instruments.export import SUFFIXES
    from skinviz.instruments.skinlog import SUFFIX

    one_of(log.suffix, (SUFFIX,), "suffix of a session's log")
    for path in export:
        one_of(path.suffix.lower(), SUFFIXES, "suffix of --export")
    if gonio is not None:
        one_of(gonio.suffix.lower(), (".csv",), "suffix of --gonio")


def _measure(wanted: Wanted, *, quiet: bool) -> None:
    """Measure, and say how to go on if it ends early."""
    from skinviz.cli.measure_bench import measured
    from skinviz.cli.measure_screen import screen
    from skinviz.instruments.errors import Stopped

    with screen(quiet=quiet) as shown:
        try:
            measured(wanted, shown)
        except KeyboardInterrupt as error:
            if not wanted.log.exists():
                raise Stopped("stopped before anything was measured") from error
            raise Stopped(
                f"stopped; all readings are in {wanted.log}, go on with --resume"
            ) from error


def _conclude(
    log: Path, export: Sequence[Path], gonio: Path | None, *, json: bool
) -> None:
    """Write and tell what follows from a log."""
    from skinviz.cli.measure_report import fitted_lobe, report_lines, session_facts
    from skinviz.instruments.derive import derive
    from skinviz.instruments.errors import InstrumentError
    from skinviz.instruments.export import export_spectra, write_lobe
    from skinviz.instruments.lobe import lobe_of
    from skinviz.instruments.skinlog import read_log

    session = read_log(log)
    try:
        derived = derive(session)
    except InstrumentError as error:
        raise type(error)(f"{log}: {error}") from error
    files: list[Path] = []
    for path in export:
        files += export_spectra(path, session, derived, str(log))
    told = session_facts(session, derived)
    if gonio is not None:
        site = derived.frames.plan.sites[0]
        files.append(write_lobe(gonio, lobe_of(derived, site), f"{log}, {site}"))
        told["lobe"] = fitted_lobe(derived, site)
    if json:
        say_json({"log": str(log), **told, "files": [str(path) for path in files]})
        return
    for line in report_lines(told):
        say(line)
    say_files([log, *files])
