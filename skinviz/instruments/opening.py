"""Sessions begun and resumed: what is in their logs before the first reading."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import asdict
from datetime import UTC, datetime

from skinviz.errors import DataError
from skinviz.instruments.certificate import Certificate
from skinviz.instruments.meters import Spectroradiometer
from skinviz.instruments.plan import Plan
from skinviz.instruments.session import WARMING, Session
from skinviz.instruments.skinlog import LogWriter, SkinLog


def begin(
    path: str,
    plan: Plan,
    certificate: Certificate,
    meter: Spectroradiometer,
    *,
    clock: Callable[[], float] = time.monotonic,
    written_by: str = "skinviz",
) -> Session:
    """Begin a session and its log.

    Parameters
    ----------
    path : str
        The log to write, which must not exist.
    plan : Plan
    certificate : Certificate
        Of the white tile.
    meter : Spectroradiometer
        Who measures, for the record; set as the plan says.
    clock : callable
        Seconds, from whenever.
    written_by : str
        Program and version, for the record.

    Raises
    ------
    SkinvizError
        If the log cannot be written.
    InstrumentError
        If the meter does not take what the plan sets; there is no log then.
    """
    _configure(meter, plan)  # what it refuses leaves no log of a plan that cannot be
    zero = clock()
    log = LogWriter.create(
        path,
        {
            "written_by": written_by,
            "utc": _now().isoformat(timespec="milliseconds"),
            "plan": plan.to_json(),
            "certificate": certificate.to_json(),
            "meter": asdict(meter.info),
        },
    )
    return Session(plan, log, 0, frozenset(), [], lambda: clock() - zero)


def resume(
    path: str,
    meter: Spectroradiometer,
    *,
    clock: Callable[[], float] = time.monotonic,
) -> Session:
    """Open a session that was interrupted.

    Parameters
    ----------
    path : str
        Its log.
    meter, clock
        As for :func:`begin`.

    Raises
    ------
    DataError
        If the log is damaged, or was measured with another instrument.
    SkinvizError
        If another program has the log open.
    """
    writer, log = LogWriter.reopen(path)
    try:
        told = log.header["meter"]
        if told != asdict(meter.info):
            raise DataError(
                f"{path} was measured with {told['model']} {told['serial']}, and "
                f"{meter.info.name} is here; use that one, or begin a new session"
            )
        plan = Plan.from_json(log.header["plan"])
        segments = [r["segment"] for r in log.records if "segment" in r]
        segment = max(segments, default=0) + 1
        began = datetime.fromisoformat(log.header["utc"])
        last = max((r["t"] for r in log.records if "t" in r), default=0.0)
        since = max(last, (_now() - began).total_seconds())
        zero = clock()
        grids = [r["wavelengths"] for r in log.records if r["kind"] == "grid"]
        session = Session(
            plan,
            writer,
            segment,
            frozenset(finished(log, plan)),
            grids,
            lambda: clock() - zero + since,
        )
        session._append("resume", torn=log.torn)
        _configure(meter, plan)
    except BaseException:
        writer.close()
        raise
    return session


def finished(log: SkinLog, plan: Plan) -> Iterable[int]:
    """Return the numbers of the steps that have all readings in one segment."""
    taken: dict[tuple[int, int], set[int]] = {}
    for record in log.records:
        if record["kind"] in ("reading", "dark") and record["step"] != WARMING:
            key = (record["step"], record["segment"])
            taken.setdefault(key, set()).add(record["repeat"])
    return sorted({step for (step, _), n in taken.items() if len(n) >= plan.repeats})


def _configure(meter: Spectroradiometer, plan: Plan) -> None:
    """Set the meter as the plan says."""
    meter.configure(exposure=plan.exposure, average=plan.average, sync=plan.sync)


def _now() -> datetime:
    """Return the moment, in universal time."""
    return datetime.now(UTC)
