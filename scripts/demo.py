"""Set everything up and run the main job: ``python3 scripts/demo.py [--out DIR]``."""

import subprocess
import sys

from _environment import ROOT, program, ready_python

if __name__ == "__main__":
    arguments = sys.argv[1:] or ["--out", str(ROOT / "demo")]
    skinviz = program(ready_python(), "skinviz")
    sys.exit(subprocess.run([skinviz, "demo", *arguments], check=False).returncode)
