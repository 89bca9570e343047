"""Files of scans and meshes: one module a kind, all giving a ``Scan``."""

import sys

from skinviz.scan.formats.range_grid import write_scan
from skinviz.scan.formats.read import read_mesh, read_scan
from skinviz.scan.formats.surface import write_mesh

if "pyvista" in sys.modules:  # loading it for this would cost a second
    from skinviz.scan.formats.pyvista_plugin import register

    register()

__all__ = ["read_mesh", "read_scan", "write_mesh", "write_scan"]
