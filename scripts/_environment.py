"""Make the project's environment, once, with nothing but Python's own library.

Used by ``scripts/demo.py`` and ``scripts/test.py``; safe to run again, and quick
when nothing has changed.
"""

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / ".venv"
CONSTRAINTS = ROOT / "constraints.txt"
SYSTEM = ROOT / "skinviz" / "_system.py"
BROWSER = "chromium"


def ready_python(*extras: str) -> Path:
    """Return the environment's Python with skinviz and its extras installed."""
    if sys.version_info < (3, 11):  # noqa: UP036 - this runs before pip checks it
        sys.exit(
            f"skinviz needs Python 3.11 or newer; this is {sys.version.split()[0]}"
        )
    python = FOLDER / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = FOLDER / "-".join(("skinviz-installed", *extras))
    wanted = _fingerprint()
    if not (python.exists() and stamp.exists() and stamp.read_text("utf-8") == wanted):
        _install(python, extras)
        stamp.write_text(wanted, encoding="utf-8")
    _ensure_system_libraries(python)
    if "dev" in extras:
        _ensure_browser()
    return python


def program(python: Path, name: str) -> str:
    """Return the path of a program of the environment."""
    return str(python.with_name(name + (".exe" if os.name == "nt" else "")))


def _fingerprint() -> str:
    """Return a mark of everything that decides what is installed."""
    files = (ROOT / "pyproject.toml", CONSTRAINTS, Path(__file__))
    content = b"".join(file.read_bytes() for file in files)
    said = f"{sys.version} {platform.machine()} {ROOT}".encode()
    return hashlib.sha256(content + said).hexdigest()


def _install(python: Path, extras: tuple[str, ...]) -> None:
    """Create the environment and install skinviz, editable, with pinned versions."""
    _ensure_ensurepip()
    print(f"setting up {FOLDER}: this downloads about 400 MB", flush=True)
    if not _has_pip(python):
        shutil.rmtree(FOLDER, ignore_errors=True)
        venv.create(FOLDER, with_pip=True)
    what = f"{ROOT}[{','.join(extras)}]" if extras else str(ROOT)
    command = [
        *(
            str(python),
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
        ),
        *("--constraint", str(CONSTRAINTS), "--editable", what),
    ]
    if subprocess.run(command, check=False).returncode:
        sys.exit("installing the packages failed; see pip's message above")


def _has_pip(python: Path) -> bool:
    """Return whether the environment is whole; a failed start leaves half of one."""
    if not python.exists():
        return False
    done = subprocess.run(
        [str(python), "-m", "pip", "--version"], capture_output=True, check=False
    )
    return done.returncode == 0


def _ensure_ensurepip() -> None:
    """Make sure that environments can be made: Debian packs that part apart."""
    try:
        import ensurepip  # noqa: F401
    except ImportError:
        name = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
        _apt_install([name], f"Python's venv module ({name})")


def _ensure_system_libraries(python: Path) -> None:
    """Install or name the libraries that VTK and pymeshlab load."""
    check = subprocess.run(
        [str(python), str(SYSTEM)], capture_output=True, text=True, check=False
    )
    if check.returncode == 0:
        return
    print(check.stderr.strip(), flush=True)
    line = check.stderr.strip().splitlines()[-1].split(" && ")[-1]
    packages = [word for word in line.split()[2:] if not word.startswith("-")]
    _apt_install(packages, "system libraries")
    again = subprocess.run([str(python), str(SYSTEM)], check=False)
    if again.returncode:
        sys.exit("the system libraries are still missing; see above")


def _ensure_browser() -> None:
    """Install or name the browser that tests of the viewer's page drive."""
    if shutil.which(BROWSER):
        return
    if _is_root() and shutil.which("apt-get"):
        _apt_install([BROWSER], "a browser for the tests of the viewer")
        return
    print(
        f"{BROWSER} is missing, which tests of the viewer's page drive: install it, or "
        "leave them out with: -m 'not browser'",
        flush=True,
    )


def _is_root() -> bool:
    """Return whether this process may install packages."""
    return hasattr(os, "geteuid") and os.geteuid() == 0


def _apt_install(packages: list[str], what: str) -> None:
    """Run apt-get as root, or say the line to run."""
    line = ["apt-get", "install", "-y", "--no-install-recommends", *packages]
    if not (_is_root() and shutil.which("apt-get")):
        sys.exit(f"{what} missing; run: apt-get update && {' '.join(line)}")
    print(f"installing {what}: {' '.join(line)}", flush=True)
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for command in (["apt-get", "update", "-qq"], [*line[:2], "-qq", *line[2:]]):
        done = subprocess.run(
            command, env=quiet, capture_output=True, text=True, check=False
        )
        if done.returncode:
            sys.exit(f"'{' '.join(command)}' failed:\n{done.stderr.strip()}")
