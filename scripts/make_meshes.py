"""Rebuild the raw views and the cleaned hands in ``meshes/`` from the true shape.

``python scripts/make_meshes.py [OUT]``: the views of the right hand are simulated, and
so are those of its mirror image, the left one, which are not kept; both are cleaned to
the edges that a picture of a hand needs. Takes a minute. ``OUT`` is ``meshes``.
"""

import sys
import tempfile
from pathlib import Path

from skinviz.cli.main import main
from skinviz.scan.formats import read_mesh, write_mesh
from skinviz.scan.shipped import CLEAN_HANDS, DEMO_SCAN, TRUE_SHAPE, shipped_mesh

SEEDS = {"right": "2005", "left": "2006"}
EDGE_LENGTH = "2"  # mm


def run(*arguments: object) -> None:
    """Run a verb of the command line, and stop if it fails."""
    if main([str(argument) for argument in arguments]) != 0:
        sys.exit(1)


def make(out: Path, scratch: Path) -> None:
    """Write the views of the right hand and both hands, cleaned."""
    right = shipped_mesh(TRUE_SHAPE)
    left = scratch / "left.ply"
    write_mesh(left, read_mesh(right, "m").reflect((1, 0, 0)).flip_faces())
    views = {"right": out / DEMO_SCAN, "left": scratch / "raw" / "hand.conf"}
    shapes = {"right": (right, "--unit", "m"), "left": (left,)}
    for side, raw in views.items():
        raw.parent.mkdir(parents=True, exist_ok=True)
        run("simulate-scan", *shapes[side], "-o", raw, "--seed", SEEDS[side])
        clean = out / CLEAN_HANDS[side]
        run("clean", raw, "-o", clean, "--edge-length", EDGE_LENGTH)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("meshes")
    with tempfile.TemporaryDirectory() as temporary:
        make(folder, Path(temporary))
