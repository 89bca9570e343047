"""Cases of the cleaning's accuracy: each simulates, cleans and compares, alone."""

import multiprocessing
import resource
import sys
import time
from dataclasses import dataclass

import numpy as np
import pyvista as pv
from _clean_compare import Difference, compare

from skinviz.errors import SkinvizError
from skinviz.scan import topology
from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh
from skinviz.scan.report import CleaningReport
from skinviz.scan.scan import Scan
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scan.simulate import Scanner, directions_around, simulate_scan
from skinviz.scene.hand import hand_frame

_KIB = 1 if sys.platform == "darwin" else 1024  # bytes in a unit of ru_maxrss


@dataclass(frozen=True)
class Case:
    """One scan to make and clean.

    Attributes
    ----------
    noise : float
        Standard deviation of range at normal incidence. [mm]
    views : int
        From around the hand.
    shift, tilt : float
        Root mean square of the poses' errors. [mm], [deg]
    left : bool
        Whether the hand is mirrored.
    pitch : float
        Of the rays. [mm]
    seed : int
        Of every random error.
    """

    noise: float = 0.1
    views: int = 8
    shift: float = 2.0
    tilt: float = 2.0
    left: bool = False
    pitch: float = 0.8
    seed: int = 0


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes
    ----------
    difference : Difference or None
        To the truth; None if the scan was refused.
    report : CleaningReport or None
        What cleaning counted.
    refusal : str
        Why, if it was.
    seconds : float
        That cleaning took. [s]
    memory : float
        Peak of the process and, of its workers, the largest, together. [GiB]
    cells : int
        Of all views' grids.
    moved : float
        Largest move of a vertex when the clean mesh is cleaned anew. [mm]
    """

    difference: Difference | None
    report: CleaningReport | None
    refusal: str
    seconds: float
    memory: float
    cells: int
    moved: float = float("nan")


def truth(left: bool = False) -> pv.PolyData:
    """Return the shape of which scans are made. [mm]"""
    points, faces = topology.arrays(read_mesh(shipped_mesh(TRUE_SHAPE), "m"))
    if left:
        points, faces = points * (-1, 1, 1), faces[:, ::-1]
    return topology.polydata(points, faces)


def scan_of(case: Case) -> Scan:
    """Return a case's raw scan."""
    shape = truth(case.left)
    frame = hand_frame(shape)
    scanner = Scanner(
        pitch=case.pitch,
        noise=case.noise,
        pose_shift=case.shift / np.sqrt(3),  # of each component
        pose_tilt=np.deg2rad(case.tilt) / np.sqrt(3),
    )
    around = directions_around(case.views, frame.fingers, frame.back)
    return simulate_scan(shape, around, scanner, np.random.default_rng(case.seed))


def alone(function, *arguments):
    """Return what a function gives in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, arguments)


def outcome(case: Case) -> Outcome:
    """Simulate, clean and compare; clean the result again."""
    scan = scan_of(case)
    cells = sum(view.valid.size for view in scan.views)
    start = time.perf_counter()
    try:
        mesh, report = clean_scan(scan)
    except SkinvizError as error:
        return Outcome(None, None, str(error), _since(start), peak(), cells)
    seconds, memory = _since(start), peak()
    again, _ = clean_scan(Scan(mesh=mesh))
    same = again.n_points == mesh.n_points
    moved = float(np.abs(again.points - mesh.points).max()) if same else float("inf")
    difference = compare(mesh, truth(case.left))
    return Outcome(difference, report, "", seconds, memory, cells, moved)


def fine_mesh(n_triangles: int) -> Outcome:
    """Clean the truth cut into that many triangles and more."""
    shape = truth()
    while shape.n_cells < n_triangles:
        shape = shape.subdivide(1, "linear")
    shape = shape.decimate(1 - n_triangles / shape.n_cells, volume_preservation=True)
    start = time.perf_counter()
    mesh, report = clean_scan(Scan(mesh=topology.polydata(*topology.arrays(shape))))
    seconds, memory = _since(start), peak()
    return Outcome(compare(mesh, truth()), report, "", seconds, memory, shape.n_cells)


def peak() -> float:
    """Return the peak memory of this process and its largest child. [GiB]"""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(w).ru_maxrss for w in who) * _KIB / 2**30


def _since(start: float) -> float:
    """Return the time since a start. [s]"""
    return time.perf_counter() - start
