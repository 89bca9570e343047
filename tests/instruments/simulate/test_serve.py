"""Servers of simulated devices: sockets, pace, and addresses."""

import contextlib
import time

import pytest
from benches import bench

from skinviz.errors import ArgumentError
from skinviz.instruments.errors import LinkLost, TooDark
from skinviz.instruments.ports import open_meter
from skinviz.instruments.simulate.pr655 import SimulatedPR655
from skinviz.instruments.simulate.serve import SocketServer
from skinviz.instruments.simulate.start import start


@contextlib.contextmanager
def _open(url):
    with start(url, bench()) as server:
        model = url.split("//")[1].split("?")[0]
        with open_meter(model, server.url, pauses=0) as meter:
            yield meter


def test_a_socket_serves_the_same_device():
    device = SimulatedPR655(bench())
    with SocketServer(device) as server:
        for _ in range(2):  # one caller after the other
            with open_meter("pr655", server.url, pauses=0) as meter:
                assert meter.measure().radiance.size == 101
        with open_meter("pr655", server.url, pauses=0) as meter:
            device.faults.add(["unplug"])
            with pytest.raises(LinkLost):
                meter.measure(within=5)


def test_a_line_can_be_as_slow_as_a_real_one():
    taken = []
    for baud in ("9600", "38400"):
        with _open(f"sim://pr650?baud={baud}") as meter:
            begun = time.monotonic()
            meter.measure()
            taken.append(time.monotonic() - begun)
    assert taken[0] > 1.7  # 1734 bytes of 10 bits
    assert taken[0] > 2 * taken[1]


def test_an_address_says_what_goes_wrong():
    with _open("sim://pr655?fault=&fault=dark&fault=over") as meter:
        meter.measure()
        with pytest.raises(TooDark):
            meter.measure()


def test_chance_is_seeded():
    def outcomes(seed):
        with _open(f"sim://pr655?rate=0.5&seed={seed}") as meter:
            return [_outcome(meter) for _ in range(4)]

    assert outcomes(4) == outcomes(4)
    assert len(set(outcomes(4))) > 1


def _outcome(meter):
    try:
        meter.measure(within=0.3)
    except Exception as error:
        return type(error).__name__
    return "read"


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("sim://pr656", "pr655"),
        ("sim://pr655?fault=fire", "silent"),
        ("sim://pr655?speed=3", "baud"),
        ("sim://pr655?rate=often", "number"),
        ("sim://pr655?rate=2", "rate"),
    ],
)
def test_addresses_that_are_none_are_refused(url, told):
    with pytest.raises(ArgumentError, match=told):
        start(url, bench())
