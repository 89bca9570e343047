"""Photo Research PR-650."""

from __future__ import annotations

from typing import ClassVar

from skinviz.instruments import pr650_replies as replies
from skinviz.instruments.errors import NoReply, WrongDevice
from skinviz.instruments.meters import DeviceInfo, Reading
from skinviz.instruments.serial_meter import SerialMeter

_RESET = 0.06  # s that RTS is low
_BOOT = 1.0  # s; within 5 s it must be spoken to
_PACE = 0.005  # s between two letters
_GAP = 0.1  # s that it is left alone after a command
_ANSWER = 5.0  # s
_ROW = 2.0  # s from one row to the next


class PR650(SerialMeter):
    """A PR-650, woken by the line RTS."""

    BAUDRATE: ClassVar[int] = 9600
    _last: bytes = b""

    def _enter(self) -> None:
        """Reset it and speak within its five seconds; switch its light off."""
        self._link.pulse_rts(_RESET)
        self._link.pause(_BOOT * self._pauses)
        self._link.drain()
        replies.require_accepted(self._ask(b"B0"))
        self._set(0.0, 1, sync=False)

    def _leave(self) -> None:
        """Do nothing: it stays in its mode until it is switched off."""

    def _identity(self) -> DeviceInfo:
        """Ask for model and serial number."""
        model = self._ask(b"D111").decode("ascii", "replace").strip()
        if "650" not in model:
            raise WrongDevice(
                f"a {model!r} answers at {self._link.name}, not a PR-650; name its "
                "model with --meter"
            )
        serial = self._ask(b"D110").decode("ascii", "replace").strip()
        return DeviceInfo("Photo Research", model, serial)

    def _learn(self) -> None:
        """Ask for the grid."""
        self._grid = replies.grid_of(self._ask(b"D120"))

    def _measure(self, within: float) -> Reading:
        """Measure; refuse by the quality code before any row is believed."""
        return self._spectrum(b"M5", within)

    def _reread(self) -> Reading:
        """Read the rows again, which a measurement that failed left as they were."""
        if not self._last:
            # As after silence: what it holds may be the measurement before.
            raise NoReply("the data of the measurement did not come; measure again")
        return self._spectrum(b"D5", _ANSWER)

    def _set(self, exposure: float, average: int, sync: bool) -> None:
        """Set what a measurement does, in SI units."""
        command = b"S01,,,,%b,%d,%02d,1" % (
            b"1" if sync else b"",
            round(1000 * exposure),
            average,
        )
        replies.require_accepted(self._ask(command))

    def _spectrum(self, command: bytes, within: float) -> Reading:
        """Return the spectrum that a command is answered with."""
        before, self._last = self._last, b""
        first = self._ask(command, within)
        replies.require_quality(first)
        self._last = first  # from now on it is this measurement that D5 would send
        rows = self._link.lines(self._grid.count + 1, _ROW)
        raw = b"".join(line + b"\r\n" for line in (first, *rows))
        self._last = raw
        again = command == b"D5" and raw == before
        found = replies.spectrum_of(raw, self._grid, doubted=again)
        return Reading(
            self._grid.wavelengths, found.radiance, None, found.warnings, raw
        )

    def _ask(self, command: bytes, within: float | None = None) -> bytes:
        """Return the line that a command is answered with."""
        self._link.send(
            command + b"\n", pace=_PACE * self._pauses, gap=_GAP * self._pauses
        )
        try:
            return self._line(_ANSWER if within is None else within)
        except NoReply as error:
            raise NoReply(
                f"{error}; its cable's switch must be at CTRL, and it was asked "
                f"{command!r}"
            ) from error
