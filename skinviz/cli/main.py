"""The ``skinviz`` program: its verbs, and how errors end it."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable, Sequence

import cyclopts

from skinviz import __version__
from skinviz.cli.archive import archive
from skinviz.cli.clean import clean
from skinviz.cli.compare import compare
from skinviz.cli.demo import demo
from skinviz.cli.figure import figure
from skinviz.cli.fit import fit
from skinviz.cli.info import info
from skinviz.cli.measure import measure
from skinviz.cli.render import render
from skinviz.cli.simulate_scan import simulate_scan
from skinviz.cli.tradeoff import tradeoff
from skinviz.cli.view import view
from skinviz.errors import SkinvizError

VERBS: dict[str, Callable[..., None] | cyclopts.App] = {
    "demo": demo,
    "clean": clean,
    "simulate-scan": simulate_scan,
    "fit": fit,
    "render": render,
    "compare": compare,
    "figure": figure,
    "tradeoff": tradeoff,
    "view": view,
    "measure": measure,
    "archive": archive,
    "info": info,
}
"""The verbs; their modules load heavy libraries only when they are called."""

DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130


def make_app() -> cyclopts.App:
    """Return the program with its verbs."""
    app = cyclopts.App(
        name="skinviz",
        help="What skin is made of, and what it looks like.",
        version=__version__,
        help_format="plaintext",
        default_parameter=cyclopts.Parameter(negative=""),
        result_action="return_value",
        suppress_keyboard_interrupt=False,  # main says so itself
    )
    for verb, function in VERBS.items():
        app.command(function, name=verb)
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return the exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after ``skinviz``; the process's own by default.

    Returns
    -------
    code : int
        0 done, 1 a ``SkinvizError`` told in one line, 2 wrong usage, 130 interrupted.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        make_app()(words, exit_on_error=False)
        sys.stdout.flush()
    except cyclopts.CycloptsError:
        return MISUSED  # cyclopts has printed what was wrong
    except SkinvizError as error:
        sys.stderr.write(f"skinviz: {' '.join(str(error).split())}\n")
        return FAILED
    except BrokenPipeError:
        # Whoever read our output has had enough: that is no failure.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        sys.stderr.write("skinviz: interrupted\n")
        return INTERRUPTED
    return DONE


def run() -> None:
    """Entry point of the console script."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a console may lack λ or Δ
            stream.reconfigure(errors="backslashreplace")
    sys.exit(main())
