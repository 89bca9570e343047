"""Drivers: their conversations to the byte, and every fault on a simulated line."""

import time

import numpy as np
import pytest
from benches import (
    GRID,
    METERS,
    bench,
    cr250_reply,
    pr650_reply,
    pr655_reply,
    script,
    simulated,
    spectrum,
)
from numpy.testing import assert_allclose

from skinviz.instruments.cr250 import CR250
from skinviz.instruments.errors import (
    CommandRejected,
    LinkLost,
    MalformedReply,
    NoReply,
    OverRange,
    TooDark,
    TruncatedReply,
    Unsteady,
    WrongDevice,
)
from skinviz.instruments.patience import patient_reading
from skinviz.instruments.ports import open_meter
from skinviz.instruments.pr650 import PR650
from skinviz.instruments.pr655 import PR655, PR670
from skinviz.instruments.simulate.pr655 import SimulatedPR655
from skinviz.instruments.simulate.serve import serve

ENTRY = [
    (b"Q", b""),
    (b"PHOTO", b"\x00REMOTE MODE"),
    (b"SU1\r", b"0000\r\n"),
    (b"D111\r", b"00000,PR-655\r\n"),
    (b"D110\r", b"00000,61234567\r\n"),
    (b"D114\r", b"00000,1.18\r\n"),
    (b"D120\r", b"00000,101,0.00,380,780,4,256,7,247\r\n"),
]
WAKING = [
    (b"B0\n", b"000\r\n"),
    (b"S01,,,,,0,01,1\n", b"000\r\n"),
    (b"D111\n", b"PR-650\r\n"),
    (b"D110\n", b"60965203\r\n"),
    (b"D120\n", b"0101,008.0,0380.,0780.,4.0\r\n"),
]
ASKING = [
    (b"RC InstrumentType\n", b"OK:0:RC InstrumentType:2\r\n"),
    (b"RC Model\n", b"OK:0:RC Model:CR-250\r\n"),
    (b"RC ID\n", b"OK:0:RC ID:A00234\r\n"),
]


def test_a_pr655_is_entered_asked_set_and_left():
    values = spectrum()
    with (
        script(
            *ENTRY,
            (b"SE100\r", b"0000\r\n"),
            (b"SN03\r", b"0000\r\n"),
            (b"SS1\r", b"0000\r\n"),
            (b"M5\r", pr655_reply(values)),
            (b"D13\r", b"00000,0,100.00\r\n"),
            (b"D5\r", pr655_reply(values)),
            (b"D13\r", b"00000,0,100.00\r\n"),
            (b"Q", b""),
        ) as link,
        PR655(link, pauses=0) as meter,
    ):
        assert meter.info.name == "Photo Research PR-655, serial number 61234567"
        meter.configure(exposure=0.1, average=3, sync=True)
        reading = meter.measure()
        assert_allclose(reading.radiance, values, rtol=5.1e-4, atol=0)
        assert reading.exposure == 0.1
        assert reading.raw == pr655_reply(values)
        assert (meter.reread().radiance == reading.radiance).all()


def test_a_pr650_is_woken_asked_and_set():
    values = spectrum()
    with script(*WAKING, (b"M5\n", pr650_reply(values))) as link:
        link.pulse_rts = lambda _: None
        with PR650(link, pauses=0) as meter:
            assert meter.info.serial == "60965203"
            assert_allclose(meter.measure().radiance, values, rtol=5.1e-4, atol=0)


def test_a_cr250_is_asked_and_set():
    values = spectrum()
    with (
        script(
            *ASKING,
            (b"SM ExposureMode 0\n", b"OK:0:SM ExposureMode:0\r\n"),
            (b"SM ExposureX 4\n", b"OK:0:SM ExposureX 4:\r\n"),
            (b"SM SyncMode 0\n", b"OK:0:SM SyncMode:0\r\n"),
            (b"M\n", b"OK:102:M:\r\n"),
            (b"RM Spectrum\n", cr250_reply(values)),
            (b"RM Exposure\n", b"OK:0:RM Exposure:12.5\r\n"),
        ) as link,
        CR250(link) as meter,
    ):
        meter.configure(average=4)
        reading = meter.measure()
        assert_allclose(reading.radiance, values, rtol=1e-6, atol=0)
        assert reading.warnings == ("no frequency found",)
        assert reading.exposure == 0.0125


@pytest.mark.parametrize(
    ("kind", "pairs"),
    [
        (PR670, ENTRY[:4]),
        (PR650, [*WAKING[:2], (b"D111\n", b"PR-655\r\n")]),
        (CR250, [(b"RC InstrumentType\n", b"OK:0:RC InstrumentType:1\r\n"), ASKING[1]]),
    ],
)
def test_another_device_is_told_and_its_port_closed(kind, pairs):
    with script(*pairs) as link:
        link.pulse_rts = lambda _: None
        with pytest.raises(WrongDevice):
            kind(link, pauses=0)
        assert link._port.closed


def test_a_silent_port_is_closed_again():
    with script((b"RC InstrumentType\n", b"OK:0:RC")) as link:
        link.line = _at_once(link.line)
        with pytest.raises(TruncatedReply, match="CR250"):
            CR250(link)
        assert link._port.closed


def _at_once(line):
    return lambda _: line(0.01)


def test_settings_that_a_model_does_not_know_are_refused():
    with simulated("pr655") as (meter, _):
        with pytest.raises(CommandRejected):
            meter.configure(exposure=29.0)
        assert meter.measure().radiance.size == 101
    with simulated("pr670") as (meter, _):
        meter.configure(exposure=29.0)
    with simulated("cr250") as (meter, _), pytest.raises(CommandRejected):
        meter.configure(exposure=1.0)


EXPECTED = {
    "silent": (NoReply,),
    "slow": (NoReply,),
    "cut": (TruncatedReply,),
    "drop_row": (TruncatedReply,),
    "dark": (TooDark,),
    "over": (OverRange,),
    "unsteady": (Unsteady,),
    "unplug": (LinkLost,),
}


@pytest.mark.parametrize("model", METERS)
@pytest.mark.parametrize("fault", EXPECTED)
def test_every_fault_has_its_error_in_time_and_the_next_measurement_succeeds(
    model, fault
):
    with simulated(model) as (meter, device):
        before = meter.measure()
        device.faults.add([fault])
        start = time.monotonic()
        with pytest.raises(EXPECTED[fault]):
            meter.measure(within=0.25 if fault in ("silent", "slow") else 2.0)
        assert time.monotonic() - start < 1.5
        if fault == "unplug":
            return
        assert_allclose(meter.measure().radiance, before.radiance, rtol=1e-3, atol=0)


@pytest.mark.parametrize("model", METERS)
@pytest.mark.parametrize("fault", ["garble", "bitflip"])
def test_garbled_spectra_are_refused_wherever_they_can_be_told(model, fault):
    values = bench().radiance(GRID.wavelengths)
    total = values.sum()
    with simulated(model) as (meter, device):
        for _ in range(8):
            device.faults.add([fault])
            try:
                reading = meter.measure()
            except (MalformedReply, TruncatedReply, NoReply):
                pass
            except (CommandRejected, WrongDevice, OverRange, TooDark, Unsteady):
                pass  # the garbled code is that of another verdict
            else:
                off = abs(np.interp(GRID.wavelengths, reading.wavelengths,
                                    reading.radiance).sum() / total - 1)  # fmt: skip
                assert model == "cr250" or off < 2e-3
        assert_allclose(meter.measure().radiance.max(), values.max(), rtol=1e-2)


def test_a_pr650_never_passes_the_spectrum_before_for_one_that_was_too_dark():
    with simulated("pr650") as (meter, device):
        meter.measure()
        device.faults.add(["dark"])
        with pytest.raises(TooDark):
            meter.measure()
        with pytest.raises(NoReply, match="measure again"):
            meter.reread()


def test_a_pr650_whose_first_line_is_lost_measures_anew():
    told = []
    with simulated("pr650") as (meter, device):
        answer = device._reply
        garbled = iter([b"??,0\r\n"])
        device._reply = lambda: next(garbled, b"") + answer()
        reading = patient_reading(meter, told.append)
    assert [type(error) for error in told] == [MalformedReply, NoReply]
    assert reading.radiance.max() > 0


def test_a_spectrum_that_was_cut_can_be_read_again_without_measuring():
    for model in METERS:
        with simulated(model) as (meter, device):
            device.faults.add(["cut"])
            taken = device.bench.time.now()
            with pytest.raises(TruncatedReply):
                meter.measure()
            reading = meter.reread()
            assert device.bench.time.now() - taken < 0.15  # one exposure of 0.1 s
            assert reading.radiance.max() > 0


def test_a_meter_that_loses_what_comes_at_once_is_entered_letter_by_letter():
    device = SimulatedPR655(bench(), hurried=True)
    with serve(device) as server, open_meter("pr655", server.url) as meter:
        assert device.remote
        assert meter.measure().radiance.size == 101


def test_a_meter_that_left_its_remote_mode_is_entered_anew():
    with simulated("pr655") as (meter, device):
        device.remote = False
        with pytest.raises(NoReply):
            meter.measure(within=0.1)
        assert meter.measure().radiance.max() > 0


@pytest.mark.parametrize("model", METERS)
def test_queued_faults_meet_one_measurement_each(model):
    with simulated(model) as (meter, device):
        device.faults.add(["", "over", ""])
        meter.measure()
        with pytest.raises(OverRange):
            meter.measure()
        meter.measure()


def test_an_answer_of_another_model_names_the_driver():
    pairs = [(b"B0\n", b"-1000\r\n")]
    with script(*pairs) as link, pytest.raises(CommandRejected, match="PR650") as seen:
        PR650(link, pauses=0)
    assert seen.value.code == -1000
