"""What all spectroradiometers on a serial port do alike: keep in step, reread, leave.

A driver says how its instrument is entered, asked and left. What does not belong here:
bytes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Self

from skinviz.instruments.errors import (
    CommandRejected,
    InstrumentError,
    LinkError,
    WrongDevice,
)
from skinviz.instruments.link import Exchange, Link
from skinviz.instruments.meters import DeviceInfo, Reading

_QUIET = 0.2  # s without a byte, after which nothing late will come
_ATTEMPTS = 3  # to get back in step; the first as if the remote mode were kept


class SerialMeter(ABC):
    """A spectroradiometer on a link.

    Parameters
    ----------
    link : Link
        Open; the driver closes it.
    pauses : float
        Share of the pauses that real instruments need; a simulated one needs none.
    """

    BAUDRATE: ClassVar[int] = 9600
    """[1/s]"""
    RTSCTS: ClassVar[bool] = False
    """Whether the handshake of the lines RTS and CTS is used."""
    LONGEST: ClassVar[float] = 60.0
    """What a measurement may take whose exposure is adaptive. [s]"""

    def __init__(self, link: Link, *, pauses: float = 1.0) -> None:
        """Enter the instrument's remote mode and ask who it is."""
        self._link = link
        self._pauses = pauses
        self._longest = self.LONGEST
        try:
            self._enter()
            self.info = self._identity()
            self._learn()
        except (LinkError, CommandRejected) as error:
            link.close()
            raise type(error)(
                f"{error} (the driver is for {type(self).__name__})",
                raw=error.raw,
                code=error.code,
            ) from error
        except InstrumentError:
            link.close()
            raise
        self._in_step = True

    info: DeviceInfo
    """Who the instrument says it is."""

    @abstractmethod
    def _enter(self) -> None:
        """Bring the instrument into its remote mode."""

    @abstractmethod
    def _leave(self) -> None:
        """Give the instrument back to its own keys."""

    @abstractmethod
    def _identity(self) -> DeviceInfo:
        """Ask who the instrument is; another one is a ``WrongDevice``."""

    def _learn(self) -> None:  # noqa: B027, not all have something to learn
        """Ask what else the driver must know."""

    @abstractmethod
    def _measure(self, within: float) -> Reading:
        """Measure once and return the data."""

    @abstractmethod
    def _reread(self) -> Reading:
        """Return the data of the last measurement."""

    @abstractmethod
    def _set(self, exposure: float, average: int, sync: bool) -> None:
        """Set integration time [s, 0 adaptive], exposures averaged, mains sync."""

    def configure(
        self, *, exposure: float = 0.0, average: int = 1, sync: bool = False
    ) -> None:
        """Set integration time [s, 0 adaptive], exposures averaged, mains sync.

        Raises
        ------
        InstrumentError
            ``CommandRejected`` if the model does not know a value.
        """
        self._keep_in_step()
        self._in_step = False
        self._set(exposure, average, sync)
        self._longest = self.LONGEST + 3 * exposure * average
        self._in_step = True

    def measure(self, *, within: float | None = None) -> Reading:
        """Measure once.

        Parameters
        ----------
        within : float, optional
            What it may take; what the model may need at most, if not said. [s]

        Returns
        -------
        reading : Reading

        Raises
        ------
        InstrumentError
            A kind for each thing that can go wrong. The next call begins by getting
            back in step with the instrument.
        """
        self._keep_in_step()
        self._in_step = False
        reading = self._measure(self._longest if within is None else within)
        self._in_step = True
        return reading

    def reread(self) -> Reading:
        """Return the last measurement's data, sent once more.

        Raises
        ------
        InstrumentError
            As for :meth:`measure`.
        """
        self._link.drain(_QUIET)
        self._in_step = False
        reading = self._reread()
        self._in_step = True
        return reading

    def transcript(self) -> tuple[Exchange, ...]:
        """Return what was said on the line since the last call."""
        return self._link.transcript()

    def close(self) -> None:
        """Leave the instrument to its own keys, and close the port."""
        try:
            self._leave()
        except InstrumentError:
            pass  # it has gone, and so there is nothing to leave
        finally:
            self._link.close()

    def __enter__(self) -> Self:
        """Return the driver, which is open."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _keep_in_step(self) -> None:
        """Throw away late replies; enter the remote mode anew if it was lost."""
        if self._in_step:
            self._link.drain()
            return
        for attempt in range(_ATTEMPTS):
            self._link.drain(_QUIET)
            try:
                if attempt:
                    self._enter()
                self._identity()
                break
            except (LinkError, WrongDevice, CommandRejected):
                if attempt == _ATTEMPTS - 1:
                    raise
        self._in_step = True

    def _line(self, within: float) -> bytes:
        """Return the next line that is not blank."""
        return self._link.wanted_line(within, bytes.strip)
