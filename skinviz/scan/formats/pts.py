"""PTS points: how many, then a line each; again for every further cloud.

A line is ``x y z``, perhaps with an intensity and a colour, which are left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skinviz.scan.formats.cloud import point_cloud
from skinviz.scan.formats.content import read_lines, shown, stated_unit, table
from skinviz.scan.formats.xyz import COMMENTS
from skinviz.scan.scan import Scan


def read_pts(path: Path, unit: str | None) -> Scan:
    """Return all points in a PTS file, in mm."""
    lines = read_lines(path, COMMENTS)
    clouds = []
    at = 0
    while at < len(lines):
        word = lines.texts[at]
        if not word.isdecimal():
            raise lines.fault(
                at, f"expected the number of points that follow, got {shown(word)}"
            )
        count, left = int(word[:19]), len(lines) - at - 1
        if count > left:
            raise lines.fault(
                at, f"not a whole PTS file: {count} points expected, {left} lines left"
            )
        clouds.append(table(lines.part(at + 1, at + 1 + count), first=3))
        at += 1 + count
    cloud = point_cloud(
        np.concatenate(clouds), path, unit, stated=stated_unit(lines.comments)
    )
    return Scan(cloud=cloud, source=str(path))
