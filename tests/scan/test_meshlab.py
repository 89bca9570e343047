"""Whatever becomes of the worker process, it comes back as one clear error."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from meshes import sphere
from skinviz.errors import ArgumentError, MeshError, SystemLibraryError
from skinviz.scan import meshlab, topology
from skinviz.scan.meshlab import Filter, Limits, run_filters

POINTS, FACES = topology.arrays(sphere(subdivisions=2))
WORKER = "_meshlab_worker.py"
NOTHING = Filter("meshing_remove_null_faces", {})


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """The folder that holds temporary folders in this test."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def worker(tmp_path, monkeypatch):
    """Put a shell script in the place of the worker's interpreter."""

    def put(script):
        program = tmp_path / "python"
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setattr(sys, "executable", str(program))

    return put


def test_points_and_faces_go_there_and_back(scratch):
    result = run_filters(POINTS, FACES, [NOTHING])
    np.testing.assert_array_equal(result.points, POINTS)
    np.testing.assert_array_equal(result.faces, FACES)
    assert list(scratch.iterdir()) == []


def test_filters_run_in_turn():
    double = Filter(
        "compute_matrix_from_translation_rotation_scale",
        {"scalex": 2.0, "scaley": 2.0, "scalez": 2.0},
    )
    result = run_filters(POINTS, FACES, [double, double])
    volume = topology.enclosed_volume(POINTS, FACES)
    after = topology.enclosed_volume(result.points, result.faces)
    assert after == pytest.approx(64 * volume, rel=1e-5)


def test_a_length_is_an_absolute_length():
    remesh = Filter(
        "meshing_isotropic_explicit_remeshing",
        {"iterations": 5, "targetlen": {"length": 8.0}},
    )
    result = run_filters(POINTS, FACES, [remesh])
    edges, _ = topology.edge_counts(result.faces)
    length = np.linalg.norm(np.diff(result.points[edges], axis=1)[:, 0], axis=1)
    assert 6 < length.mean() < 10


def test_face_scalars_select_the_faces_that_they_mark():
    marked = POINTS[FACES].mean(axis=1)[:, 2] > 0
    filters = [
        Filter("compute_selection_by_condition_per_face", {"condselect": "fq > 0"}),
        Filter("meshing_remove_selected_faces", {}),
    ]
    result = run_filters(POINTS, FACES, filters, face_scalars=marked.astype(float))
    assert len(result.faces) == (~marked).sum()


def test_a_filter_that_does_not_exist_is_told(scratch):
    with pytest.raises(MeshError, match=r"meshing_make_coffee.*failed") as caught:
        run_filters(POINTS, FACES, [Filter("meshing_make_coffee", {})])
    assert "does not exist" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert list(scratch.iterdir()) == []


def test_a_parameter_that_does_not_exist_is_told():
    wrong = Filter("meshing_close_holes", {"sugar": 2})
    with pytest.raises(MeshError, match=r"meshing_close_holes\) failed.*sugar"):
        run_filters(POINTS, FACES, [wrong])


def test_a_time_out_stops_the_worker_and_leaves_no_folder(scratch, worker, tmp_path):
    worker(f"echo $$ > {tmp_path}/pid\nexec sleep 60")
    start = time.monotonic()
    with pytest.raises(MeshError, match=r"took longer than 0\.5 s and was stopped"):
        run_filters(POINTS, FACES, [NOTHING], limits=Limits(timeout=0.5))
    assert time.monotonic() - start < 10
    assert list(scratch.iterdir()) == []
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_more_memory_than_is_allowed_is_told(scratch):
    with pytest.raises(MeshError, match=r"needs more than the 0\.05 GiB"):
        run_filters(POINTS, FACES, [NOTHING], limits=Limits(memory=0.05))
    assert list(scratch.iterdir()) == []


def test_enough_memory_changes_nothing():
    result = run_filters(POINTS, FACES, [NOTHING], limits=Limits(memory=2.0))
    np.testing.assert_array_equal(result.points, POINTS)


@pytest.mark.parametrize("values", [{"timeout": 0}, {"memory": -1}, {"memory": np.nan}])
def test_impossible_limits_are_refused(values):
    with pytest.raises(ArgumentError, match=next(iter(values))):
        Limits(**values)


def test_the_faces_that_a_filter_selects_come_back():
    marked = POINTS[FACES].mean(axis=1)[:, 2] > 0
    select = Filter("compute_selection_by_condition_per_face", {"condselect": "fq > 0"})
    result = run_filters(POINTS, FACES, [select], face_scalars=marked.astype(float))
    np.testing.assert_array_equal(result.selected, marked)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_an_ended_parent_takes_its_worker_along(tmp_path, how):
    # The worker, replaced by one that says who it is and waits, must not survive.
    program = tmp_path / "worker.py"
    program.write_text(
        "import runpy, os, pathlib, time\n"
        f"own = runpy.run_path({str(Path(meshlab.__file__).with_name(WORKER))!r})\n"
        "own['bound'](0)\n"
        f"pathlib.Path({str(tmp_path / 'pid')!r}).write_text(str(os.getpid()))\n"
        "time.sleep(60)\n"
    )
    script = (
        "import numpy as np, pathlib\n"
        "from skinviz.scan import meshlab\n"
        "class Other(type(pathlib.Path())):\n"
        f"    def with_name(self, name): return pathlib.Path({str(program)!r})\n"
        "meshlab.Path = Other\n"
        "meshlab.run_filters(np.zeros((3, 3)), np.array([[0, 1, 2]]), [])\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
    try:
        pid = int(_soon((tmp_path / "pid").read_text))
        parent.send_signal(how)
        parent.wait(20)
    finally:
        parent.kill()
    _soon(lambda: _require_gone(pid))


def _require_gone(pid):
    """Fail while a process is there and is no zombie."""
    stat = Path(f"/proc/{pid}/stat")
    if stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z":
        raise ValueError(pid)
    return "gone"


def _soon(attempt):
    """Return what an attempt gives once it succeeds, within 20 seconds."""
    end = time.monotonic() + 20
    while True:
        try:
            if told := attempt():
                return told
        except (OSError, ValueError):
            pass
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.parametrize(("name", "number"), [("SEGV", 11), ("ABRT", 6), ("KILL", 9)])
def test_a_crash_names_the_signal_and_leaves_no_folder(scratch, worker, name, number):
    worker(f"kill -{name} $$")
    with pytest.raises(MeshError, match=f"crashed with signal {number}"):
        run_filters(POINTS, FACES, [NOTHING])
    assert list(scratch.iterdir()) == []


def test_the_last_line_that_the_worker_said_is_passed_on(worker):
    worker("echo first >&2; echo 'bad alloc' >&2; exit 3")
    with pytest.raises(MeshError, match="failed: bad alloc; the mesh is likely"):
        run_filters(POINTS, FACES, [NOTHING])


def test_a_worker_that_ends_well_without_a_result_is_a_mesh_error(scratch, worker):
    worker("exit 0")
    with pytest.raises(MeshError):
        run_filters(POINTS, FACES, [NOTHING])
    assert list(scratch.iterdir()) == []


def test_a_missing_system_library_is_told_before_the_worker_starts(monkeypatch):
    def lacking(user):
        raise SystemLibraryError(f"{user} needs libGL.so.1")

    monkeypatch.setattr(meshlab, "require_system_libraries", lacking)
    with pytest.raises(SystemLibraryError, match=r"pymeshlab needs libGL\.so\.1"):
        run_filters(POINTS, FACES, [NOTHING])
