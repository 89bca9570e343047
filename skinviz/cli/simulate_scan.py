"""``skinviz simulate-scan``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import progress_bar, say_files, say_json


def simulate_scan(
    mesh: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    unit: str | None = None,
    views: Whole = 8,
    pitch: float = 0.8,
    triangulation_angle: float = 20.0,
    distance: float | None = None,
    noise: float = 0.1,
    resolution: float = 0.01,
    max_incidence: float = 75.0,
    min_return: float = 0.0,
    spikes: float = 0.3,
    outliers: float = 0.001,
    pose_shift: float = 0.5,
    pose_tilt: float = 0.3,
    seed: Whole = 0,
    json: bool = False,
) -> None:
    """Scan a known shape with a simulated laser range scanner.

    Writes raw range views (Stanford range_grid PLY) beside a .conf with the poses
    that the scanner believes: noise, depth-edge spikes, occlusion holes, lost
    grazing returns and stray outliers included.

    Example: skinviz simulate-scan hand.ply --unit m -o raw/hand.conf --seed 1

    Parameters
    ----------
    mesh
        The true shape.
    out
        The .conf file to write; the views go beside it.
    unit
        Unit of length in the mesh file, unless it states it.
    views
        How many views around the long axis.
    pitch
        Distance between neighbouring rays in mm.
    triangulation_angle
        Angle between laser and camera in degrees: a point is measured only where
        both see it.
    distance
        From the laser to the hand in mm; the camera stands beside it by distance
        times the angle's tangent. Without it the rays are parallel.
    noise
        Standard deviation of range at normal incidence in mm; it grows with the
        square of the range and as 1/cos.
    resolution
        Step to which range is rounded in mm.
    max_incidence
        Degrees from the normal beyond which there is no return.
    min_return
        Share of a white, facing point's light below which there is no return; the
        mesh's point data "albedo" (.vtp) say how dark it is.
    spikes
        Share of the points beside depth edges that spike.
    outliers
        Share of all points replaced by a stray range.
    pose_shift
        Standard deviation of each component of a pose's shift in mm.
    pose_tilt
        Standard deviation of each component of a pose's tilt in degrees.
    seed
        Seed of every random error.
    json
        Print the files as JSON.
    """
    import numpy as np

    from skinviz._validate import one_of
    from skinviz.scan.checks import require_hand_size
    from skinviz.scan.formats import read_mesh, write_scan
    from skinviz.scan.scanner import Scanner
    from skinviz.scan.simulate import directions_around
    from skinviz.scan.simulate import simulate_scan as simulate
    from skinviz.scene.hand import hand_frame

    one_of(out.suffix.lower(), (".conf",), "suffix of --out")
    scanner = Scanner(
        pitch=pitch,
        noise=noise,
        triangulation_angle=float(np.deg2rad(triangulation_angle)),
        distance=np.inf if distance is None else distance,
        resolution=resolution,
        max_incidence=float(np.deg2rad(max_incidence)),
        min_return=min_return,
        spike_fraction=spikes,
        outlier_fraction=outliers,
        pose_shift=pose_shift,
        pose_tilt=float(np.deg2rad(pose_tilt)),
    )
    with progress_bar(3) as begin:
        begin("read")
        shape = read_mesh(mesh, unit)
        require_hand_size(np.asarray(shape.points), str(mesh))
        frame = hand_frame(shape)
        begin("scan")
        directions = directions_around(views, frame.fingers, frame.back)
        scan = simulate(shape, directions, scanner, np.random.default_rng(seed))
        begin("write")
        away = "parallel" if distance is None else f"from {distance:g} mm"
        note = (
            f"simulated scan of {mesh.name}: views {views}, pitch {pitch:g} mm, noise "
            f"{noise:g} mm, rays {away}, pose error {pose_shift:g} mm "
            f"{pose_tilt:g} deg, seed {seed}"
        )
        files = write_scan(out, scan, (note,))
    if json:
        say_json({"files": [str(file) for file in files]})
    else:
        say_files(files)
