"""The main job from end to end, on the shipped data."""

import json

import numpy as np
import pytest
import pyvista as pv

from skinviz.cli.demo import SITES
from skinviz.cli.main import main


@pytest.mark.slow
def test_the_demo_writes_its_figures_mesh_and_report(tmp_path, capsys):
    out = tmp_path / "demo"
    assert main(["demo", "--out", str(out)]) == 0
    said = capsys.readouterr()
    names = {"hand.png", "sites.png", "hand.vtp", "report.json"}
    assert {path.name for path in out.iterdir()} == names
    assert all(str(out / name) in said.out for name in names)
    assert "[1/16]" in said.err

    report = json.loads((out / "report.json").read_text("utf-8"))
    assert set(report["fits"]) == set(SITES)
    for fit in report["fits"].values():
        assert fit["status"] == "converged"
        assert 0 < fit["sse_61"] < 0.011
        for weight in fit["parameters"].values():
            assert weight["lower"] <= weight["value"] <= weight["upper"]
    checked = {step["name"]: step["counts"] for step in report["cleaning"]}["check"]
    assert checked["non_manifold_edges"] == 0
    assert (checked["components"], checked["boundaries"]) == (1, 1)
    assert report["seconds"]["total"] > 0
    assert report["versions"]["skinviz"]
    for picture in report["pictures"].values():
        assert picture["plan"]["tolerance"] == 1
        assert picture["plan"]["findings"]

    mesh = pv.read(out / "hand.vtp")
    n = mesh.n_points
    assert mesh.point_data["pigments"].shape == (n, 3)
    assert mesh.point_data["radiance"].shape == (n, 61)
    assert mesh.point_data["radiance"].dtype == np.float32
    assert mesh.point_data["rgb"].dtype == np.uint8
    # Skin under D65: every lit vertex reflects more red than green than blue.
    lit = mesh.point_data["rgb"][mesh.point_data["rgb"][:, 0] > 60].astype(int)
    assert len(lit) > n / 4
    assert (np.diff(lit, axis=1) < 0).all()
