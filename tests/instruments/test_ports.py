"""Ports: listed without a byte, opened by name, refused when in doubt."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

import skinviz
from skinviz.errors import ArgumentError
from skinviz.instruments.errors import PortUnavailable
from skinviz.instruments.ports import open_meter, port_of
from skinviz.instruments.serial_ports import Port, list_ports, open_link


class _Comport(SimpleNamespace):
    def __lt__(self, other):
        return self.device < other.device


def test_listing_opens_no_port(monkeypatch):
    import serial
    from serial.tools import list_ports as system

    def refuse(*_, **__):
        raise AssertionError("a port was opened")

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    monkeypatch.setattr(serial.Serial, "open", refuse)
    found = [
        _Comport(device="/dev/ttyUSB1", description=None, vid=None, pid=None,
                 serial_number=None),
        _Comport(device="/dev/ttyACM0", description="PR-655", vid=0x861, pid=0x1003,
                 serial_number="612"),
    ]  # fmt: skip
    monkeypatch.setattr(system, "comports", lambda: found)
    assert list_ports() == (
        Port("/dev/ttyACM0", "PR-655", "0861:1003", "612"),
        Port("/dev/ttyUSB1", "", "", ""),
    )


def test_a_port_is_chosen_only_where_one_description_names_the_model():
    one = Port("/dev/ttyACM0", "PR-655 SpectraScan", "", "")
    other = Port("/dev/ttyUSB0", "USB Serial", "", "")
    assert port_of("pr655", (one, other)) == "/dev/ttyACM0"
    for ports in ((), (other,), (one, one)):
        with pytest.raises(PortUnavailable, match="--port"):
            port_of("pr655", ports)
    with pytest.raises(PortUnavailable):
        port_of("pr650", (one,))


def test_an_unknown_model_is_told_with_those_there_are():
    with pytest.raises(ArgumentError, match="pr655"):
        open_meter("pr656", "/dev/null")


def test_one_module_alone_touches_pyserial():
    root = Path(skinviz.__file__).parent
    touching = [
        path.name
        for path in root.rglob("*.py")
        if re.search(r"^\s*(import|from) serial\b", path.read_text("utf-8"), re.M)
    ]
    assert touching == ["serial_ports.py"]


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("socket://127.0.0.1", "write host and number"),
        ("socket://127.0.0.1:999999", "write host and number"),
        ("rfc2217://:4001", "write host and number"),
        ("socket://[::1", "write host and number"),
        ("/", "a folder"),
        ("/dev/null", "no serial port"),
        ("/dev/no-such", "no such port"),
        ("gopher://x", "not known"),
    ],
)
def test_what_is_no_port_is_told(url, told):
    with pytest.raises(PortUnavailable, match=told):
        open_link(url)
