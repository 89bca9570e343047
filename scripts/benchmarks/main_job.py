"""Measure the main job: accuracy beside time, for docs/physics.md.

Run in the development environment: ``python scripts/benchmarks/main_job.py``.
"""

import platform
import time
import warnings

import mpmath as mp
import numpy as np
import pyvista as pv
from scipy.spatial import cKDTree

from skinviz.scan import topology
from skinviz.scan.clean import clean_scan
from skinviz.scan.formats import read_mesh, read_scan
from skinviz.scan.shipped import DEMO_SCAN, TRUE_SHAPE, shipped_mesh
from skinviz.skin.fit import fit_skin
from skinviz.skin.kubelka_munk import kubelka_munk_layer
from skinviz.skin.models import skin_model
from skinviz.spectra.archives import load_archive
from skinviz.spectra.colorimetry import delta_e_2000, spectrum_to_xyz, xyz_to_lab
from skinviz.spectra.wavelengths import PAPER_WAVELENGTHS

SITES = ("cheek", "back of hand", "outer arm", "inner arm")


def main() -> None:
    """Print each figure with what it was measured on."""
    print(
        f"{platform.processor() or platform.machine()}, Python "
        f"{platform.python_version()}, NumPy {np.__version__}"
    )
    optics(np.random.default_rng(1))
    fits()
    colour()
    mesh()


def optics(rng: np.random.Generator, n: int = 4000) -> None:
    """Compare the layer with 60 digits, over the declared range."""
    mp.mp.dps = 150  # so that 60 digits are right after the hyperbolic form cancels
    K, S, D = (_declared(rng, n) for _ in range(3))
    R, T = kubelka_munk_layer(K, S, D)
    worst_r = worst_t = 0.0
    for k, s, d, r, t in zip(K, S, D, R, T, strict=True):
        true_r, true_t = _layer(k, s, d)
        worst_r = max(worst_r, _relative(r, true_r))
        if true_t >= mp.mpf("2.3e-308"):
            worst_t = max(worst_t, _relative(t, true_t))
    print(f"layer against mpmath, {n} points: R {worst_r:.1e}, T {worst_t:.1e}")


def fits() -> None:
    """Print the quality of the three-weight fit on the archive, and its speed."""
    archive = load_archive("issa")
    total, seconds = [], 0.0
    for site in SITES:
        spectra = archive.reflectance.values[(archive.site == site).values]
        model = skin_model(site=site, specular="included")
        start = time.perf_counter()
        fit = fit_skin(spectra, archive.wavelength.values, model)
        seconds += time.perf_counter() - start
        whole = fit.n_bands == 31
        total.append(fit.sse[whole] * 61 / 31)
        counts = dict(zip(*np.unique(fit.status, return_counts=True), strict=True))
        print(
            f"fit, {site}: mean SSE x 61/31 {total[-1].mean():.4f}, "
            f"{ {str(k): int(v) for k, v in counts.items()} }"
        )
    pooled = np.concatenate(total)
    print(
        f"fit, pooled: {pooled.mean():.4f} on {pooled.size}; "
        f"{pooled.size / seconds:.0f} spectra/s"
    )


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


def _declared(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return values over the declared range, log-uniform with zeros among them."""
    return np.where(rng.random(n) < 0.1, 0.0, 10 ** rng.uniform(-16, 16, n))


def _layer(K: float, S: float, D: float) -> tuple[mp.mpf, mp.mpf]:
    """Return R and T of eq. (3), its misprint mended, in mpmath."""
    K, S, D = (mp.mpf(float(x)) for x in (K, S, D))
    kappa = mp.sqrt(K * (K + 2 * S))
    sinh = mp.sinh(kappa * D) / kappa if kappa else D
    q = (K + S) * sinh + mp.cosh(kappa * D)
    return S * sinh / q, 1 / q


def _relative(value: float, true: mp.mpf) -> float:
    """Return the relative error, absolute where the truth is 0."""
    gap = abs(mp.mpf(float(value)) - true)
    return float(gap / abs(true)) if true else float(gap)


if __name__ == "__main__":
    main()
