"""``skinviz clean``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skinviz.cli.output import progress_bar, say, say_files, say_json, write_json


def clean(
    raw: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    unit: str | None = None,
    edge_length: float = 1.2,
    report: Path | None = None,
    timeout: float = 600.0,
    json: bool = False,
) -> None:
    """Make a clean hand mesh from a raw range scan.

    Views are triangulated without bridges over depth jumps, aligned and merged;
    islands go, holes are closed except at the wrist, and the surface is remeshed.

    Example: skinviz clean scan.conf -o hand.ply --unit mm --report report.json

    Parameters
    ----------
    raw
        Stanford .conf with its range views, a grid (.ply with range_grid, .ptx,
        .asc), or a mesh (.ply, .obj, .stl, .off, .vtp).
    out
        Mesh to write, .ply or .vtp, in mm.
    unit
        Unit of length in the file: mm, cm, m, um, inch. Needed unless the file
        states it.
    edge_length
        Target length of the edges in mm.
    report
        JSON file for what was found and done.
    timeout
        Seconds after which a step of pymeshlab is stopped.
    json
        Print the report as JSON instead of as a table.
    """
    from skinviz._validate import one_of
    from skinviz.scan.clean import STEPS, clean_scan
    from skinviz.scan.formats import read_scan, write_mesh

    one_of(out.suffix.lower(), (".ply", ".vtp"), "suffix of --out")
    scan = read_scan(raw, unit)
    steps = STEPS if scan.views else STEPS[STEPS.index("repair") :]
    with progress_bar(len(steps)) as begin:
        mesh, done = clean_scan(
            scan, edge_length=edge_length, timeout=timeout, progress=begin
        )
    files = [write_mesh(out, mesh)]
    if report is not None:
        files.append(write_json(report, done.to_dict()))
    if json:
        say_json({**done.to_dict(), "files": [str(file) for file in files]})
    else:
        say(str(done))
        say_files(files)
