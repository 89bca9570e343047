"""Colorimetry Research CR-250 and CR-300."""

from __future__ import annotations

from typing import ClassVar

from skinviz.instruments import cr250_replies as replies
from skinviz.instruments.errors import CommandRejected, LinkError, WrongDevice
from skinviz.instruments.meters import DeviceInfo, Reading
from skinviz.instruments.serial_meter import SerialMeter

_SPECTRORADIOMETER = b"2"
_ANSWER = 5.0  # s
_ROW = 2.0  # s from one value to the next


class CR250(SerialMeter):
    """A CR-250 or CR-300."""

    BAUDRATE: ClassVar[int] = 115200
    RTSCTS: ClassVar[bool] = True
    LONGEST: ClassVar[float] = 120.0

    def _enter(self) -> None:
        """Do nothing: it always listens."""

    def _leave(self) -> None:
        """Do nothing: its keys always work."""

    def _identity(self) -> DeviceInfo:
        """Ask for the type, the model and the serial number."""
        kind = self._value(b"RC InstrumentType")
        model = self._value(b"RC Model").decode("ascii", "replace")
        if kind != _SPECTRORADIOMETER:
            raise WrongDevice(
                f"a {model!r} answers at {self._link.name}, which is no "
                "spectroradiometer; name another port or model"
            )
        serial = self._value(b"RC ID").decode("ascii", "replace")
        return DeviceInfo("Colorimetry Research", model, serial)

    def _measure(self, within: float) -> Reading:
        """Measure and read the values."""
        _, warnings = replies.answer(self._ask(b"M", within), b"M")
        return self._spectrum(warnings)

    def _reread(self) -> Reading:
        """Read the values again."""
        return self._spectrum(())

    def _set(self, exposure: float, average: int, sync: bool) -> None:
        """Set how many times the adaptive exposure is multiplied, and sync."""
        if exposure:
            raise CommandRejected(
                "this model's exposure is adaptive only; leave it at 0 and set how "
                "many exposures are averaged"
            )
        factor = b"SM ExposureX %d" % average
        for command in (b"SM ExposureMode 0", factor, b"SM SyncMode %d" % sync):
            replies.answer(self._ask(command, _ANSWER), command)

    def _spectrum(self, warnings: tuple[str, ...]) -> Reading:
        """Return the spectrum that it holds."""
        header = self._ask(b"RM Spectrum", _ANSWER)
        rows = self._link.lines(replies.grid_of(header).count, _ROW)
        raw = b"".join(line + b"\r\n" for line in (header, *rows))
        grid, found = replies.spectrum_of(raw)
        return Reading(
            grid.wavelengths,
            found.radiance,
            self._exposure(),
            warnings + found.warnings,
            raw,
        )

    def _exposure(self) -> float | None:
        """Ask for the integration time; a spectrum is not lost for the want of it."""
        try:
            return replies.exposure_of(self._ask(b"RM Exposure", _ANSWER))
        except LinkError:
            return None

    def _value(self, command: bytes) -> bytes:
        """Return the value that a command is answered with."""
        return replies.answer(self._ask(command, _ANSWER), command)[0]

    def _ask(self, command: bytes, within: float) -> bytes:
        """Return the line that a command is answered with."""
        self._link.send(command + b"\n")
        return self._line(within)
