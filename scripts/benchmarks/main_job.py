"""Measure the main job: accuracy beside time, for docs/physics.md.

Colour and mesh; ``skin_fit.py`` measures the skin's optics and the fit. Run in the
development environment: ``python scripts/benchmarks/main_job.py``.
"""

import platform
import time
import warnings

import numpy as np
import pyvista as pv
from scipy.spatial import cKDTree

from skinviz.scan import topology
from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh, read_scan
from skinviz.scan.shipped import DEMO_SCAN, TRUE_SHAPE, shipped_mesh
from skinviz.skin.models import skin_model
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS


def main() -> None:
    """Print each figure with what it was measured on."""
    print(
        f"{platform.processor() or platform.machine()}, Python "
        f"{platform.python_version()}, NumPy {np.__version__}"
    )
    colour()
    mesh()


def colour() -> None:
    """Compare with colour-science's integration; print what the short range costs."""
    with warnings.catch_warnings(action="ignore"):
        import colour as oracle
    model = skin_model(site="back of hand", specular="included")
    rng = np.random.default_rng(2)
    weights = rng.uniform((0.02, 0, 0), (0.5, 0.03, 0.02), (200, 3))
    fine = np.arange(380.0, 781.0)
    for name in ("D65", "A"):
        oracle_white = spectrum_to_xyz(np.ones(401), fine, name)
        short = spectrum_to_xyz(
            model.diffuse(weights, PAPER_WAVELENGTHS), PAPER_WAVELENGTHS, name
        )
        white = spectrum_to_xyz(np.ones(61), PAPER_WAVELENGTHS, name)
        spd = oracle.SDS_ILLUMINANTS[name]
        cmfs = oracle.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
        shape = oracle.SpectralShape(400, 700, 5)
        theirs = np.array(
            [
                oracle.sd_to_XYZ(
                    oracle.SpectralDistribution(r, PAPER_WAVELENGTHS),
                    cmfs.copy().align(shape),
                    spd.copy().align(shape),
                    method="Integration",
                )
                / 100
                for r in model.diffuse(weights[:20], PAPER_WAVELENGTHS)
            ]
        )
        lab = xyz_to_lab(short, white)
        same = delta_e_2000(xyz_to_lab(theirs, white), lab[:20]).max()
        long = spectrum_to_xyz(model.diffuse(weights, fine), fine, name)
        cost = delta_e_2000(xyz_to_lab(long, oracle_white), lab)
        print(
            f"colour, {name}: to colour-science dE00 {same:.1e}; 61 bands to 1 nm "
            f"380-780 nm: mean {cost.mean():.3f}, largest {cost.max():.3f}"
        )


def mesh() -> None:
    """Compare the cleaned demo scan with the shape of which it is a scan."""
    start = time.perf_counter()
    cleaned, report = clean_scan(read_scan(shipped_mesh(DEMO_SCAN)))
    seconds = time.perf_counter() - start
    true = read_mesh(shipped_mesh(TRUE_SHAPE), "m")
    points, faces = topology.arrays(cleaned)
    true_points, true_faces = topology.arrays(true)
    distance = np.abs(_distance(points, true))
    cells, _ = true.find_closest_cell(points, return_closest_point=True)
    vectors = topology.face_vectors(true_points, true_faces)[cells]
    cosine = np.einsum("ij,ij->i", vectors, topology.vertex_normals(points, faces))
    angle = np.rad2deg(
        np.arccos(np.clip(cosine / np.linalg.norm(vectors, axis=1), -1, 1))
    )
    rim = true_points[topology.boundary_loops(true_faces)[0]]
    inside = cKDTree(rim).query(true_points)[0] > 5
    covered = np.abs(_distance(true_points[inside], cleaned))
    print(
        f"mesh: RMS {np.sqrt((distance**2).mean()):.3f}, 95 % "
        f"{np.percentile(distance, 95):.3f}, 99 % {np.percentile(distance, 99):.3f}, "
        f"largest {distance.max():.2f} mm; normals median {np.median(angle):.2f} deg; "
        f"true shape covered within 0.5 mm: {(covered < 0.5).mean():.2%}"
    )
    print(f"mesh: {seconds:.1f} s\n{report}")


def _distance(points: np.ndarray, surface: pv.PolyData) -> np.ndarray:
    """Return the distance of points to a surface, by VTK."""
    bare = topology.polydata(*topology.arrays(surface))
    return np.asarray(
        pv.PolyData(points).compute_implicit_distance(bare)["implicit_distance"]
    )


if __name__ == "__main__":
    main()
