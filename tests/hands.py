"""The shipped hand made coarse, so that tests with it stay quick."""

from functools import cache

import numpy as np

from meshes import faces_of
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scan.topology import polydata


@cache
def coarse_hand():
    """A right hand with five fingers, of some 5,000 vertices. [mm]"""
    fine = read_mesh(shipped_mesh(TRUE_SHAPE), "m").decimate(0.8)
    return polydata(np.asarray(fine.points), faces_of(fine))


def mirrored(mesh):
    """The other hand: mirrored, its faces turned outwards again."""
    points = np.asarray(mesh.points) * [-1.0, 1, 1]
    return polydata(points, faces_of(mesh)[:, [0, 2, 1]])
