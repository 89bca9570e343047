"""The one full cleaning that the tests of scans share."""

from dataclasses import dataclass

import pytest
import pyvista as pv

from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh, read_scan
from skinviz.scan.report import CleaningReport
from skinviz.scan.scan import Scan
from skinviz.scan.shipped import DEMO_SCAN, TRUE_SHAPE, shipped_mesh


@dataclass(frozen=True)
class Cleaned:
    """The shipped raw scan, what cleaning made of it, and the shape it is a scan of."""

    scan: Scan
    mesh: pv.PolyData
    report: CleaningReport
    steps_begun: tuple[str, ...]
    truth: pv.PolyData


@pytest.fixture(scope="session")
def true_hand():
    """The shape of which the shipped scan's views are taken. [mm]"""
    return read_mesh(shipped_mesh(TRUE_SHAPE), "m")


@pytest.fixture(scope="session")
def cleaned(true_hand):
    """The shipped raw scan, cleaned once for all tests; takes half a minute."""
    scan = read_scan(shipped_mesh(DEMO_SCAN))
    begun = []
    mesh, report = clean_scan(scan, progress=begun.append)
    return Cleaned(scan, mesh, report, tuple(begun), true_hand)
