"""Deadlines, framing, and what the loss of a port becomes."""

import os
import threading
import time

import pytest
from benches import ScriptedPort, script

from skinviz.instruments.errors import (
    LinkLost,
    MalformedReply,
    NoReply,
    PortUnavailable,
    Stopped,
    TruncatedReply,
)
from skinviz.instruments.link import LONGEST_LINE, Link
from skinviz.instruments.serial_ports import open_link


def _link(coming):
    port = ScriptedPort([])
    port.coming += coming
    return Link(port, "the port")


def test_lines_end_with_cr_lf_or_either_alone():
    link = _link(b"one\r\ntwo\rthree\nfour\r")
    assert [link.line(0.1) for _ in range(4)] == [b"one", b"two", b"three", b"four"]


def test_a_cr_lf_that_comes_in_two_pieces_ends_one_line():
    link = _link(b"one\r")
    assert link.line(0.1) == b"one"
    link._port.coming += b"\ntwo\r\n"
    assert link.line(0.1) == b"two"


def test_silence_is_no_reply_and_half_a_line_a_truncated_one():
    with pytest.raises(NoReply, match="did not answer"):
        _link(b"").line(0.02)
    with pytest.raises(TruncatedReply) as caught:
        _link(b"380,1.0").line(0.02)
    assert caught.value.raw == b"380,1.0"


def test_lines_that_end_too_early_keep_what_came():
    with pytest.raises(TruncatedReply, match="after 2 of 4") as caught:
        _link(b"a\r\nb\r\nc").lines(4, 0.02)
    assert caught.value.raw == b"a\r\nb\r\nc"


def test_a_flood_without_a_line_end_is_refused():
    with pytest.raises(MalformedReply, match="baud"):
        _link(b"x" * (LONGEST_LINE + 1)).line(1)
    with pytest.raises(MalformedReply, match="something else"):
        _link(b"x" * (LONGEST_LINE + 1)).until(b"REMOTE", 1)


def test_a_token_is_found_without_a_line_end():
    link = _link(b"\x00REMOTE MODErest\n")
    assert link.until(b"MODE", 0.1) == b"\x00REMOTE MODE"
    assert link.line(0.1) == b"rest"


def test_bytes_are_sent_one_at_a_time_and_the_transcript_has_both_sides():
    with script((b"M5\r", b"ok\r\n")) as link:
        link.send(b"M5\r", pace=0.001)
        assert link.line(0.1) == b"ok"
    said = [(piece.sent, piece.data) for piece in link.transcript()]
    assert said == [(True, b"M5\r"), (False, b"ok")]
    assert link.transcript() == ()


def test_an_instrument_is_left_alone_after_a_command():
    with script((b"A", b""), (b"B", b"")) as link:
        link.send(b"A", gap=0.05)
        start = time.monotonic()
        link.send(b"B")
    assert time.monotonic() - start >= 0.04


def test_waiting_ends_when_it_is_to_stop():
    stop = threading.Event()
    link = Link(ScriptedPort([]), "the port", stop=stop)
    stop.set()
    with pytest.raises(Stopped, match="kept"):
        link.line(60)
    with pytest.raises(Stopped):
        link.pause(60)


def test_ports_without_rts_are_pulsed_in_vain_and_others_low_then_high():
    master, slave = os.openpty()
    link = open_link(os.ttyname(slave))
    link.pulse_rts(0.0)
    link.close()
    os.close(master)
    os.close(slave)

    class WithLines(ScriptedPort):
        levels = ()

        @property
        def rts(self):
            return self.levels[-1]

        @rts.setter
        def rts(self, value):
            self.levels += (value,)

    port = WithLines([])
    Link(port, "the port").pulse_rts(0.0)
    assert port.levels == (False, True)


def test_a_pulled_cable_is_a_lost_link():
    master, slave = os.openpty()
    link = open_link(os.ttyname(slave))
    os.close(slave)
    os.close(master)
    with pytest.raises(LinkLost, match="--resume"):
        link.line(5)
    with pytest.raises(LinkLost):
        link.send(b"x")
    link.close()
    with pytest.raises(LinkLost):
        link.line(1)


def test_ports_that_cannot_be_opened_say_why():
    with pytest.raises(PortUnavailable, match="--list"):
        open_link("/dev/there-is-no-such-port")
    with pytest.raises(PortUnavailable, match="nothing listens"):
        open_link("socket://127.0.0.1:9")
    with pytest.raises(PortUnavailable, match="port's name"):
        open_link("nonsense://x")
    master, slave = os.openpty()
    name = os.ttyname(slave)
    first = open_link(name)
    with pytest.raises(PortUnavailable, match="another program"):
        open_link(name)
    first.close()
    os.close(master)
    os.close(slave)


class _Babbler:
    """A port that sends one thing for ever."""

    def __init__(self, said):
        self.said = said
        self.in_waiting = len(said)

    def read(self, count):
        return self.said[:count]

    def write(self, data):
        return len(data)


@pytest.mark.parametrize("said", [b"\r\n" * 200, bytes(range(32, 127)) * 9, b"!01\n"])
def test_an_instrument_that_never_pauses_is_refused_in_time(said):
    begun = time.monotonic()
    with pytest.raises(MalformedReply, match="without ever pausing"):
        Link(_Babbler(said), "the port").drain(0.2, at_most=0.2)
    assert time.monotonic() - begun < 5


def test_lines_that_nobody_wants_do_not_stretch_the_deadline():
    link = Link(_Babbler(b"\r\n" * 5), "the port")
    with pytest.raises(MalformedReply, match="something else"):
        link.wanted_line(0.05, bytes.strip)
    link = _link(b"\r\n \r\nM\r\n")
    assert link.wanted_line(0.1, bytes.strip) == b"M"
