"""Break 10,000 scan files and see what the readers make of them.

Prints a table: for each kind of file how many were read as something valid, how many
were refused by a clear error, and how many met anything else (another exception, an
empty scan, the end of the process, more than 10 s). Each read runs in a process of
its own kind with a bound on its memory, so that a crash is counted and not suffered.

    python scripts/benchmarks/fuzz_readers.py [count] [seed]
"""

import os
import resource
import signal
import sys
import tempfile
import time
import warnings
import zlib
from collections import Counter
from pathlib import Path

import numpy as np
from _print import machine

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from scan_files import KINDS, STATES_UNIT, check_scan, mutated, write_sample

from skinviz.errors import SkinvizError
from skinviz.scan.formats import read_scan

LONGEST = 10  # s
MEMORY = 2 << 30  # bytes above what the process has at its start
OUTCOMES = ("read", "clear error", "other")


def main(count: int = 10_000, seed: int = 0) -> None:
    """Print the table and every outcome that should not be."""
    print(f"{machine()}; {count} files, seed {seed}\n")
    print("| kind | files | read | clear error | other | slowest, ms |")
    print("|---|---|---|---|---|---|")
    total: Counter[str] = Counter()
    slowest = 0.0
    faults: list[str] = []
    each = -(-count // len(KINDS))
    with tempfile.TemporaryDirectory() as folder:
        for number, kind in enumerate(KINDS):
            here = Path(folder) / str(number)
            n = min(each, count - number * each)
            rows = fuzz(kind, n, seed, here)
            tally = Counter(outcome for _, outcome, _, _ in rows)
            longest = max(seconds for _, _, seconds, _ in rows)
            faults += [f"{kind} {i}: {told}" for i, o, _, told in rows if o == "other"]
            total += tally
            slowest = max(slowest, longest)
            print(_row(kind, tally, longest), flush=True)
    print(_row("all", total, slowest))
    print(*faults, sep="\n")


def _row(kind: str, tally: Counter[str], seconds: float) -> str:
    cells = [str(sum(tally.values())), *(str(tally[name]) for name in OUTCOMES)]
    return f"| {kind} | {' | '.join(cells)} | {1000 * seconds:.1f} |"


def fuzz(
    kind: str, count: int, seed: int, folder: Path
) -> list[tuple[int, str, float, str]]:
    """Return the number, outcome, time [s] and words of each mutation."""
    path = write_sample(kind, folder)
    log = folder / "log"
    content = path.read_bytes()
    rows: list[tuple[int, str, float, str]] = []
    while len(rows) < count:
        log.write_text("")
        child = os.fork()
        if child == 0:
            left = range(len(rows), count)
            _bounded_reads(kind, path, content, numbers=left, seed=seed, log=log)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        for line in log.read_text().splitlines():
            number, outcome, seconds, told = line.split("\t", 3)
            rows.append((int(number), outcome, float(seconds), told))
        if len(rows) < count:
            cause = f"the process ended: status {status}"
            rows.append((len(rows), "other", 0.0, cause))
    return rows


def _bounded_reads(
    kind: str, path: Path, content: bytes, *, numbers: range, seed: int, log: Path
) -> None:
    """Read mutated files one after the other and note each outcome."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf(
        "SC_PAGESIZE"
    )
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, size + MEMORY))
    warnings.simplefilter("error")
    with log.open("a") as file:
        for number in numbers:
            key = [seed, zlib.crc32(kind.encode()), number]
            path.write_bytes(mutated(content, np.random.default_rng(key)))
            signal.alarm(LONGEST)  # ends the process, also in compiled code
            began = time.perf_counter()
            outcome, told = _outcome(kind, path)
            seconds = time.perf_counter() - began
            signal.alarm(0)
            told = " ".join(told.split())
            file.write(f"{number}\t{outcome}\t{seconds:.6f}\t{told}\n")
            file.flush()


def _outcome(kind: str, path: Path) -> tuple[str, str]:
    """Return how a file is met, and in which words."""
    try:
        check_scan(read_scan(path, None if kind in STATES_UNIT else "mm"))
    except SkinvizError as error:
        clear = path.stem in str(error) and len(str(error)) < 600
        return ("clear error" if clear else "other"), str(error)
    except BaseException as error:
        return "other", f"{type(error).__name__}: {error}"
    return "read", ""


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
