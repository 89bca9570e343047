"""The solver by itself, for ``skin_fit.py``: its share of the time, its model calls."""

import ctypes
import time
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from _skin_data import NM, Batch
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from skinviz.skin import fit, problem, solver

CHUNK = 2048


@dataclass(frozen=True)
class Share:
    """Where the time of one thread goes. [s]"""

    solver: float
    conclusions: float
    copies: float

    @property
    def total(self) -> float:
        """All three."""
        return self.solver + self.conclusions + self.copies


def shares(batch: Batch, times: int) -> Share:
    """Return the least time of each part of a fit, on one thread. [s]"""
    shared = fit._problem(batch.model, NM)
    m, p = len(batch.spectra), len(batch.model.parameters)
    unknown, results = np.zeros((0, NM.size)), fit._room(m, p)
    taken = np.zeros((times + 1, 3))
    for k in range(times + 1):
        for i in range(0, m, CHUNK):
            rows, clock = slice(i, min(i + CHUNK, m)), time.perf_counter
            begun = clock()
            part = np.array(batch.spectra[rows], dtype=np.float64, order="C")
            found = problem.room(len(part), p)
            copied = clock()
            solver.solve(
                batch.model.evaluate,
                shared,
                part,
                unknown,
                batch.model.prior_unit,
                found,
            )
            solved = clock()
            known = fit._conclusions(shared, found, absolute=False)
            concluded = clock()
            for name, values in known.items():
                results[name][rows] = values
            copies = clock() - concluded + copied - begun
            taken[k] += solved - copied, concluded - solved, copies
    return Share(*taken[1:].min(axis=0))


def evaluations(batch: Batch) -> float:
    """Return how often the model is evaluated for one spectrum, in the mean."""
    counter = (ctypes.c_int64 * 1)()
    counting = _counting(batch.model.evaluate, ctypes.addressof(counter))
    found = problem.room(len(batch.spectra), len(batch.model.parameters))
    shared, unknown = fit._problem(batch.model, NM), np.zeros((0, NM.size))
    data = np.ascontiguousarray(batch.spectra, dtype=np.float64)
    solver.solve(counting, shared, data, unknown, batch.model.prior_unit, found)
    return counter[0] / len(data)


def _counting(evaluate: Any, address: int) -> Any:
    """Return a model that adds 1 to the number at an address, and evaluates."""

    @intrinsic
    def add_one(_typing: Any) -> Any:
        def build(context: Any, builder: Any, *_rest: Any) -> Any:
            integer = ir.IntType(64)
            place = builder.inttoptr(integer(address), integer.as_pointer())
            builder.store(builder.add(builder.load(place), integer(1)), place)
            return context.get_dummy_value()

        return types.void(), build

    @numba.njit(nogil=True)
    def counted(  # noqa: PLR0917
        values: Any, table: Any, constants: Any, scratch: Any, out: Any, slopes: Any
    ) -> None:
        add_one()
        evaluate(values, table, constants, scratch, out, slopes)

    return counted
