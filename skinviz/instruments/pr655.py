"""Photo Research PR-655 and PR-670."""

from __future__ import annotations

from typing import ClassVar

from skinviz.instruments import pr655_replies as replies
from skinviz.instruments.errors import LinkError, NoReply, WrongDevice
from skinviz.instruments.meters import DeviceInfo, Reading
from skinviz.instruments.serial_meter import SerialMeter

_PAUSE_TO_LEAVE = 0.5  # s
_PACE_TO_ENTER = 0.06  # s between the letters of PHOTO; sent at once they are lost
_PACE = 0.005  # s between the letters of other commands
_ENTERED = b"REMOTE MODE"
_ANSWER = 5.0  # s
_ROW = 2.0  # s from one row to the next


class PR655(SerialMeter):
    """A PR-655 in its remote mode."""

    MODEL: ClassVar[str] = "PR-655"

    def _enter(self) -> None:
        """Leave first: a meter in remote mode does not answer to ``PHOTO``."""
        self._leave()
        self._link.pause(_PAUSE_TO_LEAVE * self._pauses)
        self._link.drain()
        self._link.send(b"PHOTO", pace=_PACE_TO_ENTER * self._pauses)
        self._link.until(_ENTERED, within=10.0)
        self._link.drain(0.02)
        replies.require_well(self._ask(b"SU1"))  # W/(m2 sr nm)

    def _leave(self) -> None:
        """Send the one letter that is not answered."""
        self._link.send(b"Q")

    def _identity(self) -> DeviceInfo:
        """Ask for model, serial number and firmware."""
        model = replies.text_of(self._ask(b"D111"))
        if self.MODEL.split("-")[1] not in model:
            raise WrongDevice(
                f"a {model!r} answers at {self._link.name}, not a {self.MODEL}; name "
                "its model with --meter"
            )
        serial = replies.text_of(self._ask(b"D110"))
        firmware = replies.text_of(self._ask(b"D114"))
        return DeviceInfo("Photo Research", model, serial, firmware)

    def _learn(self) -> None:
        """Ask for the grid, which models differ in."""
        self._grid = replies.grid_of(self._ask(b"D120"))

    def _measure(self, within: float) -> Reading:
        """Measure, read the rows, and ask how long it exposed."""
        return self._spectrum(b"M5", within)

    def _reread(self) -> Reading:
        """Read the rows again."""
        return self._spectrum(b"D5", _ANSWER)

    def _set(self, exposure: float, average: int, sync: bool) -> None:
        """Set what a measurement does."""
        for command in (
            b"SE%d" % round(1000 * exposure),
            b"SN%02d" % average,
            b"SS%d" % sync,
        ):
            replies.require_well(self._ask(command))

    def _spectrum(self, command: bytes, within: float) -> Reading:
        """Return the spectrum that a command is answered with."""
        header = self._ask(command, within)
        replies.require_well(header)
        rows = self._link.lines(self._grid.count, _ROW)
        raw = b"".join(line + b"\r\n" for line in (header, *rows))
        found = replies.spectrum_of(raw, self._grid)
        return Reading(
            self._grid.wavelengths,
            found.radiance,
            self._exposure(),
            found.warnings,
            raw,
        )

    def _exposure(self) -> float | None:
        """Ask for the integration time; a spectrum is not lost for the want of it."""
        try:
            return replies.exposure_of(self._ask(b"D13"))
        except LinkError:
            return None

    def _ask(self, command: bytes, within: float | None = None) -> bytes:
        """Return the line that a command is answered with."""
        self._link.send(command + b"\r", pace=_PACE * self._pauses)
        try:
            return self._line(_ANSWER if within is None else within)
        except NoReply as error:
            raise NoReply(f"{error}; it was asked {command!r}") from error


class PR670(PR655):
    """A PR-670 in its remote mode, whose exposures may be longer."""

    MODEL: ClassVar[str] = "PR-670"
    LONGEST: ClassVar[float] = 300.0
