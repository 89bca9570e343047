"""Sessions: faults made good, stops, resumes, and sudden ends."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from benches import NM, bench, killed_session, run_session

from skinviz.errors import DataError, SkinvizError
from skinviz.instruments.derive import derive, read_session
from skinviz.instruments.errors import (
    DriftExceeded,
    LinkLost,
    OverRange,
    Stopped,
    Unsteady,
    WhiteMissing,
)
from skinviz.instruments.opening import finished
from skinviz.instruments.plan import Plan
from skinviz.instruments.simulate.scene import Bench, halogen
from skinviz.instruments.skinlog import read_log

PLAN = Plan(repeats=2, warm_up=False)
SHORT = Plan(repeats=2)


def _kinds(path):
    return [record["kind"] for record in read_log(path).records]


def _complete(path):
    log = read_log(path)
    plan = Plan.from_json(log.header["plan"])
    return len(finished(log, plan)) == len(plan.steps)


def test_a_session_logs_every_reading_raw_with_its_conversation(tmp_path):
    path = tmp_path / "a.skinlog"
    watching = run_session(path, PLAN, bench())
    log = read_log(path)
    readings = [r for r in log.records if r["kind"] == "reading"]
    assert len(readings) == len(PLAN.steps) * 2 == watching.seen
    assert _kinds(path)[-1] == "end"
    assert _complete(path)
    first = readings[0]
    sent = [said[2] for said in first["said"] if said[1] == ">"]
    assert "M5\r" in sent
    came = [said[2] for said in first["said"] if said[1] == "<"]
    row = f"{first['radiance'][0]:.3e}"
    assert any(line.endswith(row) for line in came)
    assert log.header["meter"]["serial"] == "61234567"
    assert not any("radiance_factor" in record for record in log.records)


def test_the_lamp_settles_first(tmp_path):
    path = tmp_path / "a.skinlog"
    run_session(path, SHORT, bench())
    warming = [r for r in read_log(path).records if r.get("step") == -1]
    sums = [sum(r["radiance"]) for r in warming if r["kind"] == "reading"]
    assert len(sums) > 5  # it begins 2 % too dim
    assert np.ptp(sums[-3:]) < 0.002 * sums[-1] < np.ptp(sums[:3])


def test_a_lamp_that_never_settles_ends_the_session(tmp_path, monkeypatch):
    monkeypatch.setattr("skinviz.instruments.session._MOST_WARMING", 6)
    lamp = halogen()
    wild = type(lamp)(lamp.wavelengths, lamp.radiance, drift=3.0)
    with pytest.raises(Unsteady, match="half an hour"):
        run_session(tmp_path / "a.skinlog", SHORT, bench(lamp=wild))


@pytest.mark.parametrize("model", ["pr655", "pr650", "cr250"])
def test_what_can_be_made_good_is(tmp_path, model, monkeypatch):
    for name in ("cr250.CR250", "serial_meter.SerialMeter"):
        monkeypatch.setattr(f"skinviz.instruments.{name}.LONGEST", 0.5)
    path = tmp_path / "a.skinlog"
    faults = ["cut", "", "silent", "drop_row", "", "unsteady"]
    watching = run_session(path, PLAN, bench(), model=model, faults=faults)
    assert set(watching.errors) == {"TruncatedReply", "NoReply", "Unsteady"}
    assert _kinds(path).count("error") == len(watching.errors)
    assert _complete(path)
    read_session(path)


def test_too_much_light_is_for_the_user_to_change(tmp_path):
    path = tmp_path / "a.skinlog"
    with pytest.raises(OverRange):
        run_session(path, PLAN, bench(), faults=["", "", "over"])
    assert _kinds(path)[-1] == "error"
    run_session(path, None, bench(), again=True)
    assert _complete(path)


def test_stray_light_that_is_too_dark_to_measure_is_none(tmp_path):
    path = tmp_path / "a.skinlog"
    on = bench(ambient=0.0)
    run_session(path, PLAN, on)
    assert _kinds(path).count("dark") == 4
    spectra = read_session(path)
    truth = np.interp(spectra.wavelength, NM, on.subject.reflectance)
    np.testing.assert_allclose(spectra.reflectance.values[0], truth, rtol=2e-3)


def test_stray_light_that_is_too_dark_once_is_still_taken_off(tmp_path):
    path = tmp_path / "a.skinlog"
    plan = Plan(repeats=3, warm_up=False)
    on = bench(ambient=0.02)
    run_session(path, plan, on, faults=["", "dark", ""])
    assert _kinds(path).count("dark") == 1
    spectra = read_session(path)
    truth = np.interp(spectra.wavelength, NM, on.subject.reflectance)
    np.testing.assert_allclose(spectra.reflectance.values[0], truth, rtol=2e-3)


def test_a_lamp_that_was_not_shuttered_is_told(tmp_path):
    class Lazy(Bench):
        def arrange(self, wanted):
            super().arrange(replace(wanted, lamp=True))

    on = bench()
    path = tmp_path / "a.skinlog"
    plan = Plan(repeats=2, warm_up=False)
    run_session(path, plan, Lazy(on.subject, on.tile, exposure=0.1, time=on.time))
    with pytest.raises(DataError, match="shuttered for stray light only"):
        read_session(path)


def test_a_pulled_cable_loses_the_reading_in_flight_and_no_other(tmp_path):
    path = tmp_path / "a.skinlog"
    with pytest.raises(LinkLost):
        run_session(path, PLAN, bench(), faults=[""] * 6 + ["unplug"])
    assert _kinds(path).count("reading") == 6
    watching = run_session(path, None, bench(), again=True)
    assert _complete(path)
    # The white is measured anew before the skin, as the lamp may have been off.
    assert watching.begun[0][0] == 1
    read_session(path)


def test_a_session_stops_when_asked_and_goes_on(tmp_path):
    path = tmp_path / "a.skinlog"
    stop = threading.Event()
    stop.set()
    with pytest.raises(Stopped, match="--resume"):
        run_session(path, PLAN, bench(), stop=stop)
    with pytest.raises(DataError, match="no reading"):
        derive(read_log(path))
    run_session(path, None, bench(), again=True)
    assert _complete(path)
    before = path.read_bytes()
    assert not run_session(path, None, bench(), again=True).begun
    assert path.read_bytes().startswith(before)


def test_an_unfinished_session_says_what_is_missing(tmp_path):
    path = tmp_path / "a.skinlog"
    # ambient and white, ambient and skin: the second white is missing
    with pytest.raises(OverRange):
        run_session(path, PLAN, bench(), faults=[""] * 8 + ["over"])
    with pytest.raises(WhiteMissing, match=r"a\.skinlog.*after.*--resume"):
        read_session(path)


def test_too_much_drift_is_refused(tmp_path):
    path = tmp_path / "a.skinlog"
    lamp = halogen()
    fast = type(lamp)(lamp.wavelengths, lamp.radiance, drift=-2.0, warm_up=0.0)
    run_session(path, PLAN, bench(lamp=fast, exposure=5.0))
    with pytest.raises(DriftExceeded, match="settle"):
        read_session(path)


def test_another_instrument_does_not_go_on(tmp_path):
    path = tmp_path / "a.skinlog"
    run_session(path, PLAN, bench())
    with pytest.raises(DataError, match="was measured with PR-655"):
        run_session(path, None, bench(), model="pr650", again=True)
    run_session(path, None, bench(), again=True)  # the log is not locked for good


def test_a_log_that_is_there_is_not_measured_over(tmp_path):
    path = tmp_path / "a.skinlog"
    run_session(path, PLAN, bench())
    with pytest.raises(SkinvizError, match="exists"):
        run_session(path, PLAN, bench())


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_sudden_end_loses_no_reading_that_was_done(tmp_path):
    rng = np.random.default_rng(3)
    for readings in (1, 2, 5, 7):
        path = tmp_path / f"{readings}.skinlog"
        after = rng.uniform(0, 0.003)
        done = killed_session(path, PLAN, readings=readings, after=after)
        assert done >= readings
        # One more may be in the log and not yet told.
        assert _kinds(path).count("reading") in (done, done + 1)
        run_session(path, None, bench(), again=True)
        assert _complete(path)
        assert read_session(path).sizes["record"] == 1
