"""The steps of cleaning by name: what each needs, gives and may be told.

What a step does is in ``scan.building`` and ``scan.mending``; a new one is a
function there and an entry in :data:`KINDS`.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, MeshError
from skinviz.scan import building, mending
from skinviz.scan.checking import check
from skinviz.scan.holes import close_holes
from skinviz.scan.meshlab import Limits
from skinviz.scan.scan import Scan
from skinviz.scan.workpiece import Counts, Surface, Workpiece

Function = Callable[..., tuple[Workpiece, Counts]]


@dataclass(frozen=True)
class Parameter:
    """A number that a step may be told.

    Attributes
    ----------
    default : float
        What it is otherwise.
    low, high : float
        What it may be.
    unit : str
        ``"mm"``, ``"rad"``, or ``""`` for a plain number.
    of_edge : bool
        Whether the default is times the target edge length of the cleaning.
    """

    default: float
    low: float
    high: float
    unit: str = ""
    of_edge: bool = False


@dataclass(frozen=True)
class Kind:
    """A kind of step.

    Attributes
    ----------
    run : callable
        ``run(workpiece, limits, **parameters)`` returns a workpiece and counts.
    needs : str
        What must be there: ``views``, ``patches``, ``points``, ``merged`` (a closed
        surface that knows where it is a guess) or ``surface``.
    gives : tuple of str
        What is there afterwards too.
    parameters : dict of Parameter
        By name.
    """

    run: Function
    needs: str
    gives: tuple[str, ...] = ()
    parameters: Mapping[str, Parameter] = field(default_factory=dict)


def _mends(function: Callable[..., tuple[Surface, Counts]]) -> Function:
    """Return a step on a surface as one on a workpiece."""

    def run(
        piece: Workpiece, limits: Limits, **parameters: float
    ) -> tuple[Workpiece, Counts]:
        if piece.surface is None:
            raise MeshError(f"{piece.source} has no surface yet")
        surface, counts = function(piece.surface, limits, **parameters)
        # Its points are others now, so what was known of their support is void.
        return replace(piece, surface=surface, merged=None), counts

    return run


_EDGE = Parameter(1.0, 0.05, 20.0, "mm", of_edge=True)
_WIDTH = Parameter(50.0, 0.0, 1e4, "mm")

KINDS: dict[str, Kind] = {
    "triangulate": Kind(
        building.triangulate,
        needs="views",
        gives=("patches", "points"),
        parameters={
            "max_incidence": Parameter(np.deg2rad(75), 0.1, np.pi / 2, "rad"),
            "max_stretch": Parameter(6.0, 1.0, 1e6),
            "min_island": Parameter(200, 0, 1e9),
            "rim_rings": Parameter(1, 0, 100),
        },
    ),
    "align": Kind(
        building.align,
        needs="patches",
        parameters={
            "reach": Parameter(6.0, 0.1, 100.0, "mm"),
            "max_residual": Parameter(1.0, 1e-3, 100.0, "mm", of_edge=True),
        },
    ),
    "drop outliers": Kind(
        building.drop_outliers,
        needs="points",
        parameters={"max_distance": Parameter(4.0, 1.0, 1e6)},
    ),
    "merge": Kind(
        building.merge,
        needs="points",
        gives=("merged", "surface"),
        parameters={
            "cell": _EDGE,
            "support": Parameter(2.0, 0.05, 100.0, "mm", of_edge=True),
        },
    ),
    "cut welds": Kind(building.cut_welds, needs="merged"),
    "open wrist": Kind(
        building.open_wrist,
        needs="merged",
        parameters={"trim": Parameter(2.0, 0.0, 100.0, "mm", of_edge=True)},
    ),
    "repair": Kind(_mends(mending.repair), needs="surface"),
    "drop islands": Kind(_mends(mending.drop_islands), needs="surface"),
    "close holes": Kind(
        _mends(close_holes),
        needs="surface",
        parameters={"max_width": _WIDTH, "cap_wrist": Parameter(0, 0, 1)},
    ),
    "remesh": Kind(
        _mends(mending.remesh), needs="surface", parameters={"edge_length": _EDGE}
    ),
    "untangle": Kind(
        _mends(mending.untangle), needs="surface", parameters={"max_width": _WIDTH}
    ),
    "check": Kind(_mends(check), needs="surface"),
}
"""The kinds of steps by name."""

MESH_STEPS = (
    *("repair", "drop islands", "close holes", "remesh", "untangle", "check"),
)
"""Names of the steps for a scan that is a mesh, in their order."""

STEPS = ("triangulate", "align", "merge", "cut welds", "open wrist", *MESH_STEPS)
"""Names of the steps for range views, in their order."""

POINT_STEPS = ("drop outliers", *STEPS[STEPS.index("merge") :])
"""Names of the steps for oriented points, in their order."""


@dataclass(frozen=True)
class Step:
    """One step of a cleaning.

    Attributes
    ----------
    name : str
        One of :data:`KINDS`.
    parameters : dict
        Those that are not to be the default. Lengths in mm, angles in radians.
    """

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse a step or a parameter that there is not."""
        if self.name not in KINDS:
            raise ArgumentError(
                f"there is no step {self.name!r} of cleaning{_meant(self.name, KINDS)}"
                f"; choose from {', '.join(KINDS)}"
            )
        known = KINDS[self.name].parameters
        for key, value in self.parameters.items():
            if key not in known:
                raise ArgumentError(
                    f"step {self.name!r} has no parameter {key!r}{_meant(key, known)}; "
                    f"it has {', '.join(known) or 'none'}"
                )
            limit = known[key]
            named = f"{key} of step {self.name!r}"
            number = int(value) if isinstance(value, bool) else value
            in_range(number, limit.low, limit.high, named, limit.unit)

    def complete(self, edge_length: float) -> dict[str, float]:
        """Return all its parameters, for a target edge length. [mm]"""
        known = KINDS[self.name].parameters
        defaults = {
            key: p.default * edge_length if p.of_edge else p.default
            for key, p in known.items()
        }
        return {**defaults, **self.parameters}


def default_steps(scan: Scan) -> tuple[Step, ...]:
    """Return the steps that clean a scan of views, a mesh or oriented points."""
    if scan.views:
        names: Sequence[str] = STEPS
    else:
        names = MESH_STEPS if scan.mesh is not None else POINT_STEPS
    return tuple(map(Step, names))


def require_order(steps: Sequence[Step], scan: Scan) -> None:
    """Refuse steps of which one lacks what it needs, or that leave no mesh.

    Raises
    ------
    ArgumentError
        Naming the step, and those that would give it what it needs.
    """
    there = {"views"} if scan.views else set()
    if not there:
        there = {"surface"} if scan.mesh is not None else {"points"}
    for step in steps:
        kind = KINDS[step.name]
        if kind.needs not in there:
            raise _out_of_order(f"step {step.name!r} needs {kind.needs}", kind.needs)
        if kind.needs in {"surface", "merged"} and step.name != "cut welds":
            there -= {"merged"}
        there |= set(kind.gives)
    if "surface" not in there:
        raise _out_of_order("the steps leave no surface", "surface")


def _out_of_order(what: str, needed: str) -> ArgumentError:
    """Return the error of steps that do not follow on each other."""
    givers = [name for name, kind in KINDS.items() if needed in kind.gives]
    advice = (
        f"put {' or '.join(map(repr, givers))} before"
        if givers
        else "which this scan has not"
    )
    return ArgumentError(f"{what} at that place; {advice}")


def _meant(name: object, known: Mapping[str, object]) -> str:
    """Return a guess at which name was meant."""
    near = difflib.get_close_matches(str(name), list(known), 1)
    return f" (did you mean {near[0]!r}?)" if near else ""
