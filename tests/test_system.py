"""Missing system libraries are named, with the line that mends it."""

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import pytest

from skinviz import _system
from skinviz.errors import SystemLibraryError

FILE = Path(_system.__file__)
WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"


@pytest.fixture
def lacking(monkeypatch):
    """Make the dynamic linker find nothing of what is named, and EGL not start."""
    _system._drawing_window.cache_clear()

    def make(*names, egl=False):
        real = ctypes.CDLL

        def load(name, *args, **kwargs):
            if any(str(name).startswith(missing) for missing in names):
                raise OSError(f"{name}: cannot open shared object file")
            return real(name, *args, **kwargs)

        monkeypatch.setattr(ctypes, "CDLL", load)
        if not egl:
            monkeypatch.setattr(_system, "_EGL_PROBE", "raise SystemExit(1)")

    yield make
    _system._drawing_window.cache_clear()


def test_this_system_lacks_nothing():
    assert _system.missing_libraries("vtk") == []
    assert _system.missing_libraries("pymeshlab") == []
    _system.require_system_libraries("vtk")
    _system.require_system_libraries("pymeshlab")


@pytest.mark.parametrize(
    "gone", [("libGL.so.1",), ("libOpenGL.so.0",), ("libGL.so.1", "libOpenGL.so.0")]
)
def test_what_pymeshlab_lacks_is_named(lacking, gone):
    lacking(*gone)
    assert _system.missing_libraries("pymeshlab") == list(gone)
    with pytest.raises(SystemLibraryError) as caught:
        _system.require_system_libraries("pymeshlab")
    message = str(caught.value)
    assert message.startswith("pymeshlab needs ")
    assert all(name in message for name in gone)
    assert f"apt-get update && {_system.APT_LINE}" in message


def test_what_vtk_lacks_is_named(lacking):
    lacking("libOSMesa")
    assert _system.missing_libraries("vtk") == [
        "a working libEGL.so.1 or libOSMesa.so.8"
    ]
    with pytest.raises(SystemLibraryError, match=r"vtk needs .*libEGL.*apt-get"):
        _system.require_system_libraries("vtk")


def test_software_drawing_does_where_egl_does_not(lacking, monkeypatch):
    lacking()
    monkeypatch.setattr(_system, "_OSMESA", ("libc.so.6",))  # stands for libOSMesa
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv(WINDOW, raising=False)
    assert _system.missing_libraries("vtk") == []
    _system.require_system_libraries("vtk")
    assert os.environ[WINDOW] == "vtkOSOpenGLRenderWindow"


def test_a_driver_that_crashes_counts_as_missing(lacking, monkeypatch):
    lacking("libOSMesa")
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    monkeypatch.setattr(_system, "_EGL_PROBE", crash)
    assert len(_system.missing_libraries("vtk")) == 1


@pytest.mark.parametrize(
    ("display", "chosen", "expected"),
    [
        ("", None, "vtkEGLRenderWindow"),
        (":0", None, None),
        ("", "vtkOSOpenGLRenderWindow", "vtkOSOpenGLRenderWindow"),
    ],
    ids=["no display", "a display", "the user's choice"],
)
def test_vtk_is_kept_from_x11_only_where_there_is_none(
    lacking, monkeypatch, display, chosen, expected
):
    lacking()
    monkeypatch.setattr(_system, "_EGL_PROBE", "raise SystemExit(0)")
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv(WINDOW, raising=False)
    if chosen:
        monkeypatch.setenv(WINDOW, chosen)
    _system.require_system_libraries("vtk")
    assert os.environ.get(WINDOW) == expected


@pytest.mark.parametrize("platform", ["darwin", "win32"])
def test_other_systems_bring_their_libraries(lacking, monkeypatch, platform):
    lacking("lib")
    monkeypatch.setattr(sys, "platform", platform)
    for user in ("vtk", "pymeshlab"):
        assert _system.missing_libraries(user) == []
        _system.require_system_libraries(user)


def test_the_apt_line_names_every_package():
    for package in _system.APT_PACKAGES:
        assert f" {package}" in _system.APT_LINE
    assert _system.APT_LINE.startswith("apt-get install -y --no-install-recommends ")


def run_alone(*arguments, code=None):
    """Run the file by itself, in a Python that sees no installed package."""
    command = [sys.executable, "-I", "-S", *(arguments or [str(FILE)])]
    if code:
        command = [sys.executable, "-I", "-S", "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_file_runs_by_itself_with_the_standard_library():
    done = run_alone()
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_file_by_itself_tells_what_is_missing():
    code = (
        "import ctypes, runpy\n"
        "def load(name): raise OSError(name)\n"
        "ctypes.CDLL = load\n"
        f"runpy.run_path({str(FILE)!r}, run_name='__main__')\n"
    )
    done = run_alone(code=code)
    assert done.returncode == 1
    assert "missing: " in done.stderr
    assert "libGL.so.1, libOpenGL.so.0" in done.stderr
    assert f"apt-get update && {_system.APT_LINE}" in done.stderr
