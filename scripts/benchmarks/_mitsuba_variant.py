"""Which of Mitsuba's spectral variants runs here: the compiled one, or the plain one.

``llvm_ad_spectral`` needs libLLVM, and Dr.Jit does not always find one that works:
versions before 15 are refused, and Debian's 15 ends the process on some processors.
So each candidate is tried in a process of its own.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

COMPILED, PLAIN = "llvm_ad_spectral", "scalar_spectral"
LIBRARY = "DRJIT_LIBLLVM_PATH"
_FOLDERS = ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64")
_TRIAL = f"""
import numpy, mitsuba
mitsuba.set_variant("{COMPILED}")
scene = mitsuba.load_dict({{
    "type": "scene", "integrator": {{"type": "direct"}}, "shape": {{"type": "sphere"}},
    "light": {{"type": "constant"}}, "sensor": {{"type": "orthographic"}}}})
assert numpy.isfinite(numpy.array(mitsuba.render(scene, spp=1))).all()
"""


def choose(asked: str | None = None) -> str:
    """Set and name the fastest variant that works, or the one that is asked for."""
    library = None if asked == PLAIN else _library()
    if library is None and asked == COMPILED:
        raise SystemExit(
            f"no libLLVM here works with Dr.Jit; install one (Debian: libllvm19) and "
            f"name it in {LIBRARY}, or use --variant {PLAIN}"
        )
    if library:
        os.environ[LIBRARY] = library
    import mitsuba

    variant = PLAIN if library is None else COMPILED
    mitsuba.set_variant(variant)
    return variant


def describe(variant: str) -> str:
    """Return the versions of Mitsuba, Dr.Jit and LLVM."""
    import drjit
    import mitsuba

    text = f"Mitsuba {mitsuba.__version__} {variant}, Dr.Jit {drjit.__version__}"
    if variant == COMPILED:
        name = Path(os.environ[LIBRARY]).resolve().name
        found = re.search(r"\d+(\.\d+)*", name)
        text += f", LLVM {found.group() if found else name}"
    return text


def _library() -> str | None:
    """Return the newest libLLVM with which a small picture comes out."""
    asked = os.environ.get(LIBRARY)
    for path in [asked] if asked else _candidates():
        environment = os.environ | {LIBRARY: path}
        trial = subprocess.run(
            [sys.executable, "-c", _TRIAL],
            env=environment,
            capture_output=True,
            check=False,
        )
        if trial.returncode == 0:
            return path
    return None


def _candidates() -> list[str]:
    """Return this system's libLLVM files, the newest first."""
    files = {
        path.resolve()
        for folder in map(Path, _FOLDERS)
        for path in folder.glob("libLLVM*.so*")
    }
    return [str(path) for path in sorted(files, key=_version, reverse=True)]


def _version(path: Path) -> int:
    """Return the version's first number in a file's name, 0 without one."""
    found = re.search(r"\d+", path.name)
    return int(found.group()) if found else 0
