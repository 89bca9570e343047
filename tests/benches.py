"""Simulated benches, ports that follow a script, and replies that are well formed."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable

import numpy as np

from skinviz.errors import SkinvizError
from skinviz.instruments import (
    cr250_replies,
    pr650_replies,
    pr655_replies,
    zaber_replies,
)
from skinviz.instruments.certificate import Certificate
from skinviz.instruments.link import Link
from skinviz.instruments.meters import Grid
from skinviz.instruments.opening import begin, resume
from skinviz.instruments.ports import open_meter
from skinviz.instruments.simulate.faults import Faults
from skinviz.instruments.simulate.hands import SimulatedHands
from skinviz.instruments.simulate.scene import Bench, QuickTime, Subject
from skinviz.instruments.simulate.serve import serve
from skinviz.instruments.simulate.start import DEVICES
from skinviz.skin.models import skin_model
from skinviz.surface.lobe_curve import in_plane
from skinviz.surface.torrance_sparrow import TorranceSparrow

NM = np.arange(360.0, 801.0)
GRID = Grid(380.0, 4.0, 101)
METERS = ("pr655", "pr670", "pr650", "cr250")


def skin(wavelengths=NM):
    """Return a smooth reflectance, higher in red as skin's is."""
    return 0.15 + 0.35 / (1 + np.exp(-(wavelengths - 590) / 25))


def subject(lobe=None, n=1.4):
    """Return skin with a lobe ``f(illumination, viewing)`` in degrees, none if None."""
    light, view = np.arange(-85.0, 86.0), np.arange(0.0, 86.0)
    table = np.zeros((light.size, view.size))
    if lobe is not None:
        table = table + lobe(light[:, None], view)
    return Subject(NM, skin(), light, view, table, n)


def bench(**options):
    """Return a bench without noise or drift, unless said, in quick time."""
    quiet = {"shot": 0.0, "read": 0.0, "exposure": 0.1, "time": QuickTime()}
    tile = (NM, 0.98 - 0.02 * (NM - 360) / 440)
    return Bench(**({"subject": subject(), "tile": tile} | quiet | options))


WEIGHTS = np.array([0.12, 0.006, 0.004])
LOBE = TorranceSparrow.from_beta(1.2, 0.27)
MODEL = skin_model(site="back of hand", specular="excluded")


def human(weights=WEIGHTS, lobe=LOBE):
    """Return skin of known weights with a known lobe."""
    nm = np.arange(380.0, 781.0)
    light, view = np.arange(-85.0, 86.0), np.arange(0.0, 86.0)
    table = in_plane(lobe, np.deg2rad(light)[:, None], np.deg2rad(view))
    return Subject(nm, MODEL.measured(weights, nm), light, view, table, 1.4)


def certificate(on):
    """Return the certificate of a bench's tile, right to the last digit."""
    nm, factor = on.tile
    return Certificate(nm, factor, np.full(nm.size, 0.001), "tile.csv", "0" * 64)


class Watching:
    """Counts what a session tells."""

    def __init__(self):
        self.begun, self.seen, self.errors = [], 0, []

    def begins(self, step, of):
        self.begun.append((step.number, of))

    def read(self, step, readings, of):  # noqa: ARG002
        self.seen += 1

    def failed(self, error):
        self.errors.append(type(error).__name__)


NOISY = {"shot": 0.004, "read": 0.0003, "exposure": 5.0}


def run_session(
    path,
    plan,
    on,
    *,
    model="pr655",
    again=False,
    faults=(),
    stop=None,
    certified=None,
):
    """Measure a plan on a bench, or what is left of it; return who watched.

    ``certified`` is the tile's certificate, if that is not right to the last digit.
    """
    watching = Watching()
    with simulated(model, on=on) as (meter, device):
        device.faults.add(faults)
        hands = SimulatedHands(on, 10.0)
        clock = on.time.now
        if again:
            session = resume(path, meter, clock=clock)
        else:
            told = certificate(on) if certified is None else certified
            session = begin(path, plan, told, meter, clock=clock)
        with session.log:
            session.run(
                meter, hands.stage(), hands, watching, stop=stop, pause=on.time.elapse
            )
    return watching


@contextlib.contextmanager
def simulated(model, *, on=None, **options):
    """Yield an open driver and its simulated device."""
    faults = Faults(late=0.6)
    device = DEVICES[model](bench() if on is None else on, faults, **options)
    with serve(device) as server, open_meter(model, server.url, pauses=0) as meter:
        yield meter, device


class Telling:
    """Writes the count of readings that are done into a pipe."""

    def __init__(self, pipe):
        self.pipe, self.count = pipe, 0

    def begins(self, step, of):
        pass

    def read(self, step, readings, of):  # noqa: ARG002
        self.count += 1
        os.write(self.pipe, self.count.to_bytes(4, "big"))

    def failed(self, error):
        pass


def killed_session(path, plan, *, readings=0, after=0.0):
    """Measure in a process that is killed after so many readings, then seconds.

    Return how many readings it had said to be done.
    """
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            on = bench()
            with simulated("pr655", on=on) as (meter, _):
                hands = SimulatedHands(on, 1.0)
                session = begin(path, plan, certificate(on), meter, clock=on.time.now)
                with session.log:
                    session.run(
                        meter,
                        hands.stage(),
                        hands,
                        Telling(theirs),
                        pause=on.time.elapse,
                    )
        finally:
            os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb", buffering=0) as pipe:
        told = b"".join(pipe.read(4) for _ in range(readings))
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        told += pipe.readall()
    return int.from_bytes(told[-4:], "big")


class ScriptedPort:
    """A port that expects what is sent and answers it, to the byte."""

    def __init__(self, pairs):
        """Take pairs of what is sent and what then comes."""
        self.pairs = list(pairs)
        self.coming = bytearray()
        self.sent = bytearray()
        self.closed = False

    @property
    def in_waiting(self):
        return len(self.coming)

    def write(self, data):
        self.sent += data
        expected, answer = self.pairs[0]
        assert expected.startswith(bytes(self.sent)), (bytes(self.sent), expected)
        if expected == self.sent:
            self.pairs.pop(0)
            self.sent.clear()
            self.coming += answer
        return len(data)

    def read(self, count):
        data = bytes(self.coming[:count])
        del self.coming[:count]
        return data

    def close(self):
        self.closed = True


@contextlib.contextmanager
def script(*pairs):
    """Yield a link over a port that expects these pairs, all of them."""
    port = ScriptedPort(pairs)
    yield Link(port, "the port")
    assert not port.pairs, f"never sent: {port.pairs}"


def spectrum(seed=0, grid=GRID):
    """Return a positive spectrum."""
    rng = np.random.default_rng(seed)
    return 1e-3 * (1 + rng.random(grid.count))


def pr655_reply(values, grid=GRID, *, digits=2):
    """Return an answer to M5 as the manual shows it."""

    def told(x):
        mantissa, exponent = f"{x:.3e}".split("e")
        return f"{mantissa}e{int(exponent):+0{digits + 1}d}"

    rows = [f"{w:.0f},{told(v)}" for w, v in zip(grid.wavelengths, values, strict=True)]
    head = f"00000,0,5.400e+002,{told(values.sum() * grid.step)},1.0e+10"
    return ("\r\n".join([head, *rows]) + "\r\n").encode()


def pr650_reply(values, quality="00", integral=None):
    """Return an answer to M5: 6 + 11 + 101 rows of 17 bytes."""
    total = values.sum() * 4 if integral is None else integral
    rows = [
        f"{w:04.0f}.,{v:.3E}" for w, v in zip(GRID.wavelengths, values, strict=True)
    ]
    return ("\r\n".join([f"{quality},0", f"{total:.3E}", *rows]) + "\r\n").encode()


def cr250_reply(values):
    """Return an answer to RM Spectrum."""
    head = "OK:0:RM Spectrum:380.0,780.0,4.0,101"
    return ("\r\n".join([head, *(f"{v:.6e}" for v in values)]) + "\r\n").encode()


PARSERS: dict[str, tuple[bytes, Callable[[bytes], object]]] = {
    "PR-655 spectrum": (
        pr655_reply(spectrum()),
        lambda raw: pr655_replies.spectrum_of(raw, GRID),
    ),
    "PR-655 grid": (b"00000,101,0.00,380,780,4,256,7,247", pr655_replies.grid_of),
    "PR-655 text": (b"00000,PR-655", pr655_replies.text_of),
    "PR-655 exposure": (b"00000,0,120.00", pr655_replies.exposure_of),
    "PR-650 spectrum": (
        pr650_reply(spectrum()),
        lambda raw: pr650_replies.spectrum_of(raw, GRID),
    ),
    "PR-650 grid": (b"0101,008.0,0380.,0780.,4.0", pr650_replies.grid_of),
    "PR-650 acknowledgement": (b"000", pr650_replies.require_accepted),
    "CR-250 spectrum": (cr250_reply(spectrum()), cr250_replies.spectrum_of),
    "CR-250 answer": (
        b"OK:0:RC Model:CR-250",
        lambda raw: cr250_replies.answer(raw, b"RC Model"),
    ),
    "CR-250 exposure": (b"OK:0:RM Exposure:120.00", cr250_replies.exposure_of),
    "Zaber reply": (
        b"@01 1 03 OK IDLE -- 96000:"
        + zaber_replies.checksum(b"01 1 03 OK IDLE -- 96000"),
        lambda raw: zaber_replies.require_sound(zaber_replies.reply_of(raw)),
    ),
}
"""A well formed reply and the function that reads it, by what they are."""


WORDS = (b"nan", b"inf", b"1e999", b"-", b"_", b"\r", b"\r\n", b",", b"\0")

ACCIDENTS: tuple[Callable[[bytearray, int, np.random.Generator], None], ...] = (
    lambda data, at, rng: data.__setitem__(slice(at, at + 1), rng.bytes(1)),
    lambda data, at, rng: data.__delitem__(slice(at, at + int(rng.integers(1, 40)))),
    lambda data, at, rng: data.__setitem__(slice(at, at), rng.bytes(rng.integers(20))),
    lambda data, at, _: data.__delitem__(slice(at, None)),
    lambda data, at, rng: data.__setitem__(
        slice(at, at), data[at : at + int(rng.integers(1, 60))]
    ),
    lambda data, at, rng: data.__setitem__(
        slice(at, at), WORDS[int(rng.integers(len(WORDS)))]
    ),
    lambda data, at, rng: data.__setitem__(
        slice(at, at + 1),
        bytes(b ^ 1 << int(rng.integers(8)) for b in data[at : at + 1]),
    ),
)
"""Replace a byte, lose some, insert noise, end, repeat, insert a word, flip a bit."""


def mutated(content: bytes, rng: np.random.Generator) -> bytes:
    """Return a reply after one to four accidents."""
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, len(data) + 1))
        ACCIDENTS[int(rng.integers(len(ACCIDENTS)))](data, at, rng)
    return bytes(data)


def met(parse: Callable[[bytes], object], raw: bytes) -> str:
    """Return how a parser meets bytes: "read", or its error's class.

    Anything but a ``SkinvizError`` goes through.
    """
    try:
        parse(raw)
    except SkinvizError as error:
        told = error
    else:
        return "read"
    assert 10 < len(str(told)) < 400, str(told)
    return type(told).__name__
