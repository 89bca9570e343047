"""The package as a whole: what an import costs, what is public, what is shipped."""

import ast
import importlib
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import skinviz

ROOT = Path(__file__).parents[1]
HEAVY = {
    *("pyvista", "vtkmodules", "pymeshlab", "matplotlib", "scipy", "xarray", "pandas"),
    *("trimesh", "embreex", "rich", "cyclopts", "colour", "numba", "serial"),
    *("PIL", "OpenEXR", "tifffile"),
}


def _loaded_after(statement):
    code = f"import sys; {statement}; print(*sorted(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    return {name.split(".")[0] for name in done.stdout.split()}


@pytest.mark.parametrize(
    "statement",
    [
        "import skinviz",
        "import skinviz; skinviz.read_spectra",
        "import skinviz; skinviz.TorranceSparrow()",
    ],
)
def test_imports_stay_cheap(statement):
    assert not _loaded_after(statement) & HEAVY


def test_help_loads_no_heavy_library():
    statement = (
        "from skinviz.cli.main import main; import contextlib, io; "
        "exec('with contextlib.redirect_stdout(io.StringIO()):\\n main([\"--help\"])')"
    )
    drawn_by = {"rich", "cyclopts"}
    assert not _loaded_after(statement) & (HEAVY - drawn_by)


@pytest.mark.parametrize("name", skinviz.__all__)
def test_every_public_name_resolves(name):
    assert getattr(skinviz, name) is not None


def test_the_lazy_names_are_those_that_type_checkers_see():
    tree = ast.parse((ROOT / "skinviz" / "__init__.py").read_text("utf-8"))
    guarded = next(
        node for node in tree.body if isinstance(node, ast.If)
    )  # if TYPE_CHECKING
    seen = {
        alias.name: statement.module
        for statement in guarded.body
        for alias in statement.names
    }
    assert {n: f"skinviz.{home}" for n, home in skinviz._HOME.items()} == seen


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = skinviz.nothing


def test_the_version_is_stated_once_and_everywhere_the_same():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    assert f"version: {skinviz.__version__}" in citation
    assert f"## {skinviz.__version__}" in changelog


def test_the_wheel_carries_meshes_spectra_and_types(tmp_path):
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d"]
    subprocess.run([*build, str(tmp_path)], cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    raw = "skinviz/meshes/makehuman_male_right_raw"
    assert {
        *("skinviz/py.typed", "skinviz/skin/data/effective.csv", f"{raw}/hand.conf"),
        *(f"{raw}/view_{i:02d}.ply" for i in range(8)),
        *(f"skinviz/meshes/makehuman_male_{s}_clean.ply" for s in ("left", "right")),
        "skinviz/spectra/data/issa_2025_part_360-740nm_10nm.csv.gz",
    } <= names


def test_pinned_versions_hold_no_addresses():
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert pins
    assert all(line.count("==") == 1 and "/" not in line for line in pins)


def test_errors_form_one_tree():
    errors = importlib.import_module("skinviz.errors")
    raised = [e for e in vars(errors).values() if isinstance(e, type)]
    wanted = skinviz.SkinvizError | skinviz.SceneWarning
    assert all(issubclass(error, wanted) for error in raised)
    assert issubclass(skinviz.ArgumentError, ValueError)
