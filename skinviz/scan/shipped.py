"""The meshes and raw scans that come with skinviz."""

from __future__ import annotations

from pathlib import Path

from skinviz.errors import MeshError

DEMO_SCAN = "makehuman_male_right_raw/hand.conf"
"""Eight simulated raw range views of a man's right hand."""

CLEAN_HANDS = {
    "right": "makehuman_male_right_clean.ply",
    "left": "makehuman_male_left_clean.ply",
}
"""That scan and one of the mirrored shape, cleaned to edges of 2 mm."""

TRUE_SHAPE = "makehuman_male_right.ply"
"""The shape of which they are views; open at the wrist."""


def shipped_mesh(name: str) -> Path:
    """Return the path of a shipped mesh or scan, installed or in a checkout.

    Raises
    ------
    MeshError
        If it is not there.
    """
    package = Path(__file__).parents[1]
    for folder in (package / "meshes", package.parent / "meshes"):
        if (folder / name).is_file():
            return folder / name
    raise MeshError(f"the shipped mesh {name} is missing; install skinviz anew")
