"""Stages: turning by hand, and a Zaber on a simulated line."""

import contextlib
import threading
import time

import pytest
from benches import bench, script

from skinviz.instruments.errors import (
    LinkLost,
    NoReply,
    NotHomed,
    OutOfTravel,
    StageFault,
    Stopped,
    WrongDevice,
)
from skinviz.instruments.ports import open_stage
from skinviz.instruments.simulate.faults import Faults
from skinviz.instruments.simulate.scene import RealTime
from skinviz.instruments.simulate.serve import serve
from skinviz.instruments.simulate.zaber import SimulatedZaber
from skinviz.instruments.stages import ManualStage, ZaberStage


@contextlib.contextmanager
def _stage(**options):
    quick = {"speed": 2000.0, "faults": Faults(late=0.3)}
    device = SimulatedZaber(bench(), **(quick | options))
    with serve(device) as server, open_stage("zaber", server.url) as stage:
        yield stage, device


def test_a_person_is_asked_once_for_an_angle():
    asked = []
    stage = ManualStage(lambda words, degrees: asked.append((words, degrees)))
    assert stage.move(30) == stage.angle == 30.0
    stage.move(30.0)
    stage.move(-15)
    assert asked == [
        ("turn the lamp to 30 degrees", 30),
        ("turn the lamp to -15 degrees", -15),
    ]


def test_a_zaber_turns_the_lamp():
    with _stage() as (stage, device):
        for angle in (60.0, -30.0, 85.0):
            assert stage.move(angle) == pytest.approx(angle, abs=1e-3)
            assert device.bench.arrangement.illumination == pytest.approx(
                angle, abs=1e-3
            )
            assert stage.angle == pytest.approx(angle, abs=1e-3)
        stage.home()
        assert stage.angle == 0


def test_a_stage_that_lost_its_place_must_be_homed():
    with _stage(homed=False) as (stage, _):
        with pytest.raises(NotHomed, match="home"):
            stage.move(10)
        stage.home()
        assert stage.move(10) == pytest.approx(10, abs=1e-3)


def test_a_stage_refuses_what_is_out_of_its_travel():
    with _stage() as (stage, _):
        with pytest.raises(OutOfTravel):
            stage.move(120)
        assert stage.move(80) == pytest.approx(80, abs=1e-3)


def test_a_stage_that_is_blocked_says_so():
    with _stage() as (stage, device):
        device.fault_flag = b"FS"
        with pytest.raises(StageFault, match="FS"):
            stage.move(10)


def test_a_stage_that_takes_too_long_is_stopped():
    with _stage(speed=0.1) as (stage, device):
        with pytest.raises(StageFault, match="stopped"):
            stage.move(60, within=0.05)
        assert device.place == device.goal


@pytest.mark.parametrize(
    "fault", ["alert", "garble", "bitflip", "cut", "silent", "slow"]
)
def test_what_is_garbled_once_is_asked_again(fault):
    with _stage() as (stage, device):
        for angle in range(0, 30, 10):
            device.faults.add([fault])
            assert stage.move(angle) == pytest.approx(angle, abs=1e-3)
            assert device.bench.arrangement.illumination == pytest.approx(
                angle, abs=1e-3
            )


def test_a_stage_that_stays_silent_or_is_pulled_out_is_told():
    with _stage() as (stage, device):
        device.faults.add(["silent"] * 3)
        with pytest.raises(NoReply):
            stage.move(10)
        device.faults.add(["unplug"])
        with pytest.raises(LinkLost):
            stage.move(20)


@pytest.mark.parametrize("told", [b"0", b"none", b"nan"])
def test_a_stage_that_does_not_turn_is_refused(told):
    asked = b"/01 1 01 get limit.cycle.dist:"
    from skinviz.instruments.zaber_replies import command

    with script((command("get limit.cycle.dist", message=1), b"@01 1 01 OK IDLE -- "
                 + told + b"\r\n")) as link:  # fmt: skip
        assert command("get limit.cycle.dist", message=1).startswith(asked)
        with pytest.raises(WrongDevice):
            ZaberStage(link)


def test_zero_may_be_elsewhere():
    with _stage() as (_, device), serve(device) as server:
        with open_stage("zaber", server.url, zero=10.0) as stage:
            stage.move(20)
        assert device.place == pytest.approx(30, abs=1e-3)


def test_the_lamp_stops_where_the_program_is_stopped():
    stop = threading.Event()
    device = SimulatedZaber(bench(time=RealTime()), speed=5.0)
    with serve(device) as server, open_stage("zaber", server.url, stop=stop) as stage:
        threading.Timer(0.1, stop.set).start()
        with pytest.raises(Stopped):
            stage.move(80)
        time.sleep(0.3)
        assert device.place == device.goal < 10
