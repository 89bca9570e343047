"""``skinviz clean``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skinviz.cli.output import progress_bar, say, say_files, say_json, write_json


def clean(
    *raw: Annotated[Path, Parameter(required=True)],
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    unit: str | None = None,
    edge_length: float = 1.2,
    steps: Path | None = None,
    report: Path | None = None,
    preview: Path | None = None,
    timeout: float = 600.0,
    memory: float = 0.0,
    json: bool = False,
) -> None:
    """Make a clean hand mesh from a raw range scan.

    Views are triangulated without bridges over depth jumps, aligned and merged;
    islands go, holes are closed except at the wrist, and the surface is remeshed.
    What is done can be said step by step in a file.

    Example: skinviz clean scan.conf -o hand.ply --unit mm --report report.json

    Parameters
    ----------
    raw
        Stanford .conf with its range views, one or more grids (.ply with
        range_grid, .ptx, .asc), a mesh (.ply, .obj, .stl, .off, .vtp), or points
        with normals (.ply, .xyz).
    out
        Mesh to write, .ply or .vtp, in mm.
    unit
        Unit of length in the file: mm, cm, m, um, inch. Needed unless the file
        states it.
    edge_length
        Target length of the edges in mm.
    steps
        TOML file with a table [[step]] for each step, instead of the usual ones.
    report
        JSON file for what was found and done.
    preview
        Picture (.png, .svg, .pdf) of back and palm before and after, with holes and
        non-manifold edges marked.
    timeout
        Seconds after which a step of pymeshlab is stopped.
    memory
        GiB that a step of pymeshlab may hold; 0 for no bound.
    json
        Print the report as JSON instead of as a table.
    """
    from skinviz._validate import one_of
    from skinviz.scan.clean import clean_scan
    from skinviz.scan.formats import read_scan, write_mesh
    from skinviz.scan.scan import joined
    from skinviz.scan.steps import default_steps
    from skinviz.scan.steps_file import read_steps

    one_of(out.suffix.lower(), (".ply", ".vtp"), "suffix of --out")
    given = None if steps is None else read_steps(steps)
    scan = joined([read_scan(file, unit) for file in raw])
    chosen = default_steps(scan) if given is None else given
    with progress_bar(len(chosen)) as begin:
        mesh, done = clean_scan(
            scan,
            edge_length=edge_length,
            steps=chosen,
            timeout=timeout,
            memory=memory,
            progress=begin,
        )
    files = [write_mesh(out, mesh)]
    if report is not None:
        files.append(write_json(report, done.to_dict()))
    if preview is not None:
        from skinviz.view.figures import save_figure
        from skinviz.view.scan_preview import scan_preview

        files.append(save_figure(scan_preview(scan, mesh), preview))
    if json:
        say_json({**done.to_dict(), "files": [str(file) for file in files]})
    else:
        say(str(done))
        say_files(files)
