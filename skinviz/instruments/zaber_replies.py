"""Zaber's ASCII protocol, as pure functions of bytes."""

from __future__ import annotations

import re
from dataclasses import dataclass

from skinviz.instruments.errors import (
    CommandRejected,
    MalformedReply,
    NotHomed,
    OutOfTravel,
    StageFault,
)

_REPLY = re.compile(
    rb"@(\d{2}) (\d) (?:(\d{2}) )?(OK|RJ) (BUSY|IDLE) ([A-Z-][A-Z0-9-]) ?(.*)"
)


@dataclass(frozen=True)
class StageReply:
    """What a stage answers.

    Attributes
    ----------
    accepted, busy : bool
        Whether the command was taken, and whether the stage moves.
    flag : str
        The most urgent warning, "--" if none.
    data : str
        What was asked, or why it was rejected.
    message : int or None
        The number of the command that this answers.
    """

    accepted: bool
    busy: bool
    flag: str
    data: str
    message: int | None


def checksum(body: bytes) -> bytes:
    """Return the two digits that make a line's bytes add up to 0 in eight bits.

    Examples
    --------
    >>> checksum(b"01 1 get pos")
    b'7C'
    """
    return b"%02X" % (-sum(body) % 256)


def command(words: str, *, address: int = 1, axis: int = 1, message: int = 0) -> bytes:
    """Return a command with its number, checksum and end."""
    body = f"{address:02d} {axis} {message:02d} {words}".rstrip().encode("ascii")
    return b"/" + body + b":" + checksum(body) + b"\n"


def reply_of(line: bytes) -> StageReply:
    """Return what a line that begins with ``@`` says.

    Raises
    ------
    MalformedReply
        If its checksum is wrong, or it is no reply.
    """
    body = line.strip()
    if body[-3:-2] == b":":
        body, told = body[:-3], body[-2:]
        if told.upper() != checksum(body[1:]):
            raise MalformedReply(
                "the checksum of the stage's reply is wrong; ask again, and check the "
                "cable if it stays so",
                raw=line,
            )
    found = _REPLY.fullmatch(body)
    if found is None:
        raise MalformedReply(
            f"{line[:40]!r} is no reply of a Zaber stage; check that the port is the "
            "stage's and that it speaks ASCII at 115200 baud",
            raw=line,
        )
    number, verdict, state, flag, data = found.groups()[2:]
    return StageReply(
        accepted=verdict == b"OK",
        busy=state == b"BUSY",
        flag=flag.decode("ascii"),
        data=data.decode("ascii", "replace").strip(),
        message=None if number is None else int(number),
    )


def require_sound(reply: StageReply) -> None:
    """Raise what a reply complains of.

    Raises
    ------
    StageFault
        For a flag of a fault.
    NotHomed, OutOfTravel, CommandRejected
        For a rejection.
    """
    if reply.flag.startswith("F"):
        raise StageFault(
            f"the stage reports the fault {reply.flag}; take away what blocks it, "
            "switch it off and on, and home it"
        )
    if reply.accepted:
        return
    if reply.flag == "WR":
        raise NotHomed("the stage does not know where it is; home it first")
    if reply.data.startswith("BADDATA"):
        raise OutOfTravel("the stage cannot go there; choose an angle in its travel")
    raise CommandRejected(
        f"the stage rejected a command: {reply.data or 'no reason told'}; check that "
        "it is a rotary stage"
    )
