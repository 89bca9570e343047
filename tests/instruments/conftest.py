"""Shorter waits: simulated instruments need none of a real one's."""

import pytest


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch):
    for model in ("pr655", "pr650", "cr250"):
        monkeypatch.setattr(f"skinviz.instruments.{model}._ROW", 0.3)
        monkeypatch.setattr(f"skinviz.instruments.{model}._ANSWER", 0.5)
    monkeypatch.setattr("skinviz.instruments.serial_meter._QUIET", 0.03)
    monkeypatch.setattr("skinviz.instruments.stages._ANSWER", 0.2)
    monkeypatch.setattr("skinviz.instruments.stages._POLL", 0.005)
    for name in ("pr655.PR670", "cr250.CR250", "serial_meter.SerialMeter"):
        monkeypatch.setattr(f"skinviz.instruments.{name}.LONGEST", 2.0)
