"""Which system libraries drawing and mesh repair need, checked before loading.

VTK crashes the interpreter where it finds no way to draw, and pymeshlab silently
loses filters where a library is missing, so the check has to come first.
Standard library only: the set-up runs this file before anything is installed.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from functools import cache

APT_PACKAGES = ("libegl1", "libgl1", "libgl1-mesa-dri", "libopengl0")
"""Debian and Ubuntu packages with which everything works off-screen."""

APT_LINE = "apt-get install -y --no-install-recommends " + " ".join(APT_PACKAGES)
"""The one line that mends whatever is missing, after ``apt-get update``."""

_MESHLAB = ("libGL.so.1", "libOpenGL.so.0")
_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"  # by it VTK is told not to look for X11

# libEGL alone is only a dispatcher: what counts is that a driver behind it starts
# without a display (EGL_PLATFORM_SURFACELESS_MESA, else the first device). In a
# process of its own, since some drivers crash instead of failing.
_EGL_PROBE = """
import ctypes as c
egl = c.CDLL("libEGL.so.1")
find = egl.eglGetProcAddress
find.restype, find.argtypes = c.c_void_p, [c.c_char_p]
start = egl.eglInitialize
start.argtypes = [c.c_void_p] * 3
get = c.CFUNCTYPE(c.c_void_p, c.c_uint, c.c_void_p, c.c_void_p)(
    find(b"eglGetPlatformDisplayEXT"))
list_devices = find(b"eglQueryDevicesEXT")
screens = [get(0x31DD, None, None)]
if list_devices:
    devices, n = (c.c_void_p * 8)(), c.c_int()
    c.CFUNCTYPE(c.c_uint, c.c_int, c.c_void_p, c.c_void_p)(list_devices)(
        8, devices, c.byref(n))
    screens += [get(0x313F, d, None) for d in devices[:n.value]]
raise SystemExit(not any(s and start(s, None, None) for s in screens))
"""


def missing_libraries(user: str) -> list[str]:
    """Return what ``user`` ("vtk" or "pymeshlab") lacks, in words; empty if fine.

    Only Linux is checked: elsewhere the libraries come with the system.
    """
    if not sys.platform.startswith("linux"):
        return []
    if user == "pymeshlab":
        return [name for name in _MESHLAB if not _loads(name)]
    return [] if _drawing_window() else ["a working libEGL.so.1 or libOSMesa.so.8"]


def require_system_libraries(user: str) -> None:
    """Raise unless ``user`` ("vtk" or "pymeshlab") finds its system libraries.

    For VTK, also make it draw off-screen without looking for an X server, where
    there is none and the user has not chosen otherwise.

    Raises
    ------
    SystemLibraryError
        Names what is missing and the line that mends it.
    """
    from skinviz.errors import SystemLibraryError

    missing = missing_libraries(user)
    if missing:
        raise SystemLibraryError(
            f"{user} needs {' and '.join(missing)}, which this system lacks; install "
            f"with: apt-get update && {APT_LINE}"
        )
    window = _drawing_window() if user == "vtk" else None
    if window and not os.environ.get("DISPLAY"):
        os.environ.setdefault(_WINDOW, window)


@cache
def _drawing_window() -> str | None:
    """Return the VTK window class that can draw off-screen here, if any can."""
    if not sys.platform.startswith("linux"):
        return None
    probe = subprocess.run(
        [sys.executable, "-c", _EGL_PROBE], capture_output=True, check=False
    )
    if probe.returncode == 0:
        return "vtkEGLRenderWindow"
    if any(_loads(name) for name in _OSMESA):
        return "vtkOSOpenGLRenderWindow"
    return None


def _loads(name: str) -> bool:
    """Return whether the dynamic linker finds a library."""
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    lacking = [
        what for user in ("vtk", "pymeshlab") for what in missing_libraries(user)
    ]
    if lacking:
        sys.exit("missing: " + ", ".join(lacking) + f"\napt-get update && {APT_LINE}")
