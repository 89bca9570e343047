"""The ``skinviz`` program: its verbs, and how errors end it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import cyclopts

from skinviz import __version__
from skinviz.errors import SkinvizError

VERBS = {
    "demo": "The main job on the data that comes with skinviz.",
    "clean": "Make a clean hand mesh from a raw range scan.",
    "simulate-scan": "Scan a known shape with a simulated laser scanner.",
    "fit": "Fit pigment weights to measured skin spectra.",
    "render": "Draw a scene in spectrally computed colour.",
    "info": "Say what a scene or a scan holds and what will be computed.",
}

DONE, FAILED, MISUSED = 0, 1, 2


def make_app() -> cyclopts.App:
    """Return the program with its verbs, each loaded when it is called."""
    app = cyclopts.App(
        name="skinviz",
        help="What skin is made of, and what it looks like.",
        version=__version__,
        help_format="plaintext",
        # Help for a verb's options comes from its function; the list does not.
        result_action="return_value",
    )
    for verb, summary in VERBS.items():
        function = verb.replace("-", "_")
        app.command(f"skinviz.cli.{function}:{function}", name=verb, help=summary)
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
        0 done, 1 a ``SkinvizError`` told in one line, 2 wrong usage.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        make_app()(words, exit_on_error=False)
    except cyclopts.CycloptsError:
        return MISUSED  # cyclopts has printed what was wrong
    except SkinvizError as error:
        sys.stderr.write(f"skinviz: {' '.join(str(error).split())}\n")
        return FAILED
    except KeyboardInterrupt:
        sys.stderr.write("skinviz: interrupted\n")
        return FAILED
    return DONE


def run() -> None:
    """Entry point of the console script."""
    sys.exit(main())
