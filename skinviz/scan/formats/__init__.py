"""Files of scans and meshes: one module a kind, all giving a ``Scan``."""

from skinviz.scan.formats.range_grid import write_scan
from skinviz.scan.formats.read import read_mesh, read_scan
from skinviz.scan.formats.surface import write_mesh

__all__ = ["read_mesh", "read_scan", "write_mesh", "write_scan"]
