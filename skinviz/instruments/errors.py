"""What can go wrong between a computer and an instrument, each told with what to do.

What does not belong here: when to try again (``instruments.patience``).
"""

from __future__ import annotations

from skinviz.errors import SkinvizError


class InstrumentError(SkinvizError):
    """Base of what instruments and measurements raise.

    Attributes
    ----------
    raw : bytes
        What the instrument sent, as far as it came.
    code : int or None
        The instrument's own number for it.
    """

    def __init__(
        self, message: str, *, raw: bytes = b"", code: int | None = None
    ) -> None:
        """Take one line that says what to do."""
        super().__init__(message)
        self.raw = raw
        self.code = code


class PortUnavailable(InstrumentError):
    """The port is absent, in use or forbidden."""


class LinkError(InstrumentError):
    """Base of what goes wrong on the way between computer and instrument."""


class NoReply(LinkError):
    """Nothing came before the deadline."""


class TruncatedReply(LinkError):
    """A reply began and did not end."""


class MalformedReply(LinkError):
    """A reply that cannot be what the instrument meant."""


class LinkLost(InstrumentError):
    """The cable or the connection went while it was in use."""


class Stopped(InstrumentError):
    """Waiting ended because the user asked for it."""


class InstrumentVerdict(InstrumentError):
    """Base of what the instrument itself says of the light."""


class TooDark(InstrumentVerdict):
    """Too little light for a measurement."""


class OverRange(InstrumentVerdict):
    """Too much light for a measurement."""


class Unsteady(InstrumentVerdict):
    """The light changed or flickered while it was measured."""


class MeasurementRefused(InstrumentVerdict):
    """The instrument could not measure for another reason of its own."""


class CommandRejected(InstrumentError):
    """The instrument does not know a command or a value."""


class WrongDevice(InstrumentError):
    """Something else answers on this port."""


class DeviceFault(InstrumentError):
    """The instrument reports that its hardware is faulty."""


class StageFault(InstrumentError):
    """The stage reports a fault or did not reach its place."""


class NotHomed(StageFault):
    """The stage does not know where it is."""


class OutOfTravel(StageFault):
    """The stage cannot go there."""


class DriftExceeded(InstrumentError):
    """The lamp changed too much between two readings of the white."""


class WhiteMissing(InstrumentError):
    """There is no reading of the white that a sample could be compared with."""
