"""Set everything up and run every check: ``python3 scripts/test.py [PYTEST ARGS]``."""

import subprocess
import sys
import time

from _environment import ROOT, program, ready_python

# A process takes up to 2 GiB. Tests that are left go to whoever is done first.
IN_PARALLEL = ("-n", "auto", "--maxprocesses", "4", "--dist", "worksteal")


def main() -> int:
    """Run format, lint, types, import contract and tests; stop at the first failure."""
    python = ready_python("dev")
    checks = {
        "format": [program(python, "ruff"), "format", "--check", "."],
        "lint": [program(python, "ruff"), "check", "."],
        "types": [program(python, "mypy")],
        "imports": [program(python, "lint-imports"), "--no-logo"],
        "tests": [str(python), "-m", "pytest", "-q", *IN_PARALLEL, *sys.argv[1:]],
    }
    for name, command in checks.items():
        print(f"== {name}", flush=True)
        start = time.monotonic()
        code = subprocess.run(command, cwd=ROOT, check=False).returncode
        print(f"== {name}: {time.monotonic() - start:.0f} s", flush=True)
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
