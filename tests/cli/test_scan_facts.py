"""``skinviz info`` of scans: what is in them, and what of a hand."""

import json

import numpy as np
import pytest

from meshes import joined, moved, pose, sphere, toy_hand
from skinviz.cli.main import main
from skinviz.cli.scan_facts import scan_facts
from skinviz.scan import topology
from skinviz.scan.formats import read_mesh, read_scan, write_mesh
from skinviz.scan.scan import Scan
from skinviz.scan.shipped import DEMO_SCAN, TRUE_SHAPE, shipped_mesh
from skinviz.scan.topology import polydata


def test_a_hand_is_told_with_its_side_length_wrist_and_back():
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), "m")
    facts = scan_facts(Scan(mesh=mesh))
    assert facts["mesh"] == "26965 vertices, 53760 triangles"
    assert "size" not in facts
    first, wrist, back = facts["hand"]
    assert first.startswith("right, ")
    assert first.endswith("mm from wrist to fingertip (adults: 140 to 230)")
    assert wrist.startswith("wrist: opening of 168 points, 54.0 mm wide")
    assert "the direction 0/0" in back


def test_the_mirror_image_is_the_left_hand():
    points, faces = topology.arrays(read_mesh(shipped_mesh(TRUE_SHAPE), "m"))
    left = polydata(points * [1, -1, 1], faces[:, ::-1])
    assert scan_facts(Scan(mesh=left))["hand"][0].startswith("left, ")


def test_an_unusual_length_is_noted():
    points, faces = topology.arrays(toy_hand())
    first, *_ = scan_facts(Scan(mesh=polydata(2 * points, faces)))["hand"]
    assert first.endswith("is it an adult's, is the unit right?")


def test_a_unit_that_cannot_be_is_told_with_the_likely_one():
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), "mm")  # it is in metres
    size = scan_facts(Scan(mesh=mesh))["size"]
    assert size.endswith("as if metres were read as millimetres; check the unit")


def test_what_is_no_hand_says_why():
    assert scan_facts(Scan(mesh=sphere(90)))["hand"] == (
        "not recognised: the mesh has no opening at the wrist, so the direction of "
        "its fingers is unknown"
    )


def test_views_are_told_with_the_extent_of_all():
    facts = scan_facts(read_scan(shipped_mesh(DEMO_SCAN)))
    assert len(facts["views"]) == 8
    assert facts["views"][0] == "view_00: 267 x 234 cells, 25337 returns, parallel rays"
    assert "size" not in facts


def test_pieces_are_counted():
    mesh = joined(toy_hand(), moved(sphere(5, 1), pose(shift=(0, 0, 150))))
    assert scan_facts(Scan(mesh=mesh))["pieces"] == "2"


@pytest.mark.parametrize("suffix", [".xyz", ".vtp"])
def test_the_program_prints_lines_and_json(tmp_path, capsys, suffix):
    file = tmp_path / f"a{suffix}"
    if suffix == ".vtp":
        write_mesh(file, toy_hand())
    else:
        np.savetxt(file, toy_hand().points)
    assert main(["info", str(file), "--unit", "mm"]) == 0
    said = capsys.readouterr().out
    assert main(["info", str(file), "--unit", "mm", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["extent"] in said
    if suffix == ".xyz":
        assert "without normals; no grid or faces join them" in facts["points"]
    else:
        assert facts["hand"][0] in said
