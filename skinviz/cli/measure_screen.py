"""What ``skinviz measure`` shows: the guide, the spectrum, the scatter of repeats."""

from __future__ import annotations

import contextlib
import sys
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinviz.cli.measure_hands import in_words
from skinviz.errors import SkinvizError
from skinviz.instruments.errors import InstrumentError, Stopped
from skinviz.instruments.meters import Reading
from skinviz.instruments.plan import Step

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.live import Live

_WIDTH, _HEIGHT = 64, 12  # of the plot, in letters
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of Braille's letters
_BLANK = 0x2800
_LABEL, _FRAME, _OTHER_LINES = 11, 4, 9  # left of the plot, around all, not the plot
_LEAST = 16  # letters, below which a plot says nothing
_AXIS = "radiance, W/(m² sr nm)"
_LINE = 78
_SETTLING = "until three in a row agree"
_BULLET = textwrap.TextWrapper(_LINE, initial_indent="  * ", subsequent_indent="    ")


class Screen:
    """Tells in lines on standard error; asks on a terminal, or not at all."""

    def ask(self, requests: list[str]) -> None:
        """Show what to do and return when it is done.

        Raises
        ------
        SkinvizError
            If nobody can be asked.
        Stopped
            If the answer is q.
        """
        for request in requests:
            self._write(_BULLET.fill(request))
        _forget_keys()
        while True:
            self._write("Press Enter when it is done, q and Enter to stop: ", end="")
            answer = sys.stdin.readline() if sys.stdin else ""
            if not answer:
                raise SkinvizError(
                    "nobody is there to arrange the bench; run this in a terminal, or "
                    "with --yes at a simulated one"
                )
            if not answer.strip():
                return
            if answer.strip().lower() in ("q", "quit"):
                raise Stopped("stopped as asked; go on with --resume")

    def begins(self, step: Step, of: int) -> None:
        """Tell the step that begins."""
        name = in_words(step.arrangement, step.sweep)
        self._write(f"[{step.number + 1}/{of}] {name}" if step.number >= 0 else
                    f"[warm-up] {name}")  # fmt: skip

    def read(self, step: Step, readings: Sequence[Reading], of: int) -> None:
        """Take the readings so far: lines say no more than the step."""

    def failed(self, error: InstrumentError) -> None:
        """Tell an error that is being made good."""
        self._write(f"  made good: {error}")

    def _write(self, text: str, end: str = "\n") -> None:
        """Write to standard error."""
        sys.stderr.write(text + end)
        sys.stderr.flush()


class Silent(Screen):
    """Tells nothing but what must be asked."""

    def begins(self, step: Step, of: int) -> None:
        """Tell nothing."""

    def failed(self, error: InstrumentError) -> None:
        """Tell nothing: it is in the log."""


class LiveScreen(Screen):
    """Shows the step, the last spectrum and the scatter of repeats in a terminal."""

    def __init__(self, console: Console) -> None:
        """Take what draws."""
        self._console = console
        self._live = self._shown()
        self._title = ""
        self._share = 0.0
        self._last: Reading | None = None
        self._facts = ""
        self._error = ""

    def ask(self, requests: list[str]) -> None:
        """Ask in place of what is shown."""
        self._live.stop()
        self._console.print(self._title, style="bold", markup=False, highlight=False)
        super().ask(requests)
        self._live = self._shown()

    def close(self) -> None:
        """Take it away."""
        self._live.stop()

    def begins(self, step: Step, of: int) -> None:
        """Show the step that begins."""
        place = f"{step.number + 1} of {of}" if step.number >= 0 else "warm-up"
        self._title = f"{place}: {in_words(step.arrangement, step.sweep)}"
        self._share = max(step.number, 0) / of
        self._facts = self._error = ""
        self._draw()

    def read(self, step: Step, readings: Sequence[Reading], of: int) -> None:  # noqa: ARG002
        """Show the last spectrum and the scatter."""
        last = self._last = readings[-1]
        facts = [f"reading {len(readings)} {f'of {of}' if of else _SETTLING}"]
        if last.exposure is not None:
            facts.append(f"exposure {last.exposure:.3g} s")
        if len(readings) > 1:
            whole, band = scatter([reading.radiance for reading in readings])
            facts.append(f"scatter of repeats {whole:.2%}, in a band {band:.2%}")
        self._facts = "; ".join([*facts, *last.warnings])
        self._draw()

    def failed(self, error: InstrumentError) -> None:
        """Show an error that is being made good."""
        self._error = f"made good: {error}"
        self._draw()

    def _shown(self) -> Live:
        """Return what begins to show where the cursor is."""
        from rich.live import Live

        live = Live(console=self._console, auto_refresh=False, transient=True)
        live.start()
        return live

    def _draw(self) -> None:
        """Draw all."""
        self._live.update(self._panel(), refresh=True)

    def _plot(self) -> list[str]:
        """Return the last spectrum as large as there is room, none if too little."""
        width = min(_WIDTH, self._console.width - _FRAME - _LABEL)
        height = min(_HEIGHT, self._console.height - _OTHER_LINES)
        if self._last is None or width < _LEAST or height < _LEAST // 4:
            return []
        return plotted(
            self._last.wavelengths, self._last.radiance, width=width, height=height
        )

    def _panel(self) -> RenderableType:
        """Return what is shown."""
        from rich.console import Group
        from rich.panel import Panel
        from rich.text import Text

        whole = max(1, min(_WIDTH + _LABEL, self._console.width - _FRAME))
        done = round(self._share * whole)
        bar = Text("━" * done, style="green")
        bar.append("━" * (whole - done), style="dim")
        parts: list[RenderableType] = [bar]
        parts += [Text(line, no_wrap=True) for line in self._plot()]
        if self._facts:
            parts.append(Text(self._facts))
        if self._error:
            parts.append(Text(self._error, style="yellow"))
        return Panel(Group(*parts), title=self._title, title_align="left")


@contextlib.contextmanager
def screen(*, quiet: bool) -> Iterator[Screen]:
    """Yield where it is shown how measuring goes: a terminal, lines, or nothing.

    Terminals that cannot go back, or have no letters to draw with, get lines.
    """
    if quiet:
        yield Silent()
        return
    from rich.console import Console

    console = Console(stderr=True)
    drawn = console.is_terminal and not console.is_dumb_terminal
    if not drawn or not console.encoding.startswith("utf"):
        yield Screen()
        return
    shown = LiveScreen(console)
    try:
        yield shown
    finally:
        shown.close()


def _forget_keys() -> None:
    """Forget what was typed before the question: it cannot be the answer."""
    if sys.stdin and sys.stdin.isatty():
        with contextlib.suppress(ImportError, OSError):
            import termios

            termios.tcflush(sys.stdin, termios.TCIFLUSH)


def scatter(spectra: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    """Return the relative standard deviation of sums over bands, and of a band. [1]"""
    stack = np.array(spectra)
    mean = float(stack.mean())
    if mean <= 0:
        return 0.0, 0.0
    whole = float(stack.mean(axis=1).std(ddof=1))
    return whole / mean, float(stack.std(axis=0, ddof=1).mean()) / mean


def plotted(
    wavelengths: NDArray[np.float64],
    values: NDArray[np.float64],
    *,
    width: int = _WIDTH,
    height: int = _HEIGHT,
) -> list[str]:
    """Return a spectrum drawn in Braille letters, with its axes' ends.

    Parameters
    ----------
    wavelengths, values : (n,) ndarray
        [nm], and what is drawn from 0 up to its largest.
    width, height : int
        Letters; a letter has two dots across and four down.
    """
    most = float(values.max())
    columns, rows = 2 * width, 4 * height
    at = np.linspace(wavelengths[0], wavelengths[-1], columns)
    level = np.interp(at, wavelengths, values) / (most if most > 0 else 1.0)
    y = np.clip(np.round((1 - level) * (rows - 1)), 0, rows - 1).astype(int)
    cells = np.zeros((height, width), dtype=int)
    for x in range(columns):
        # Down to where the curve was before, so that steep parts stay joined.
        low, high = sorted((int(y[x]), int(y[max(x - 1, 0)])))
        for row in range(low, high + 1):
            cells[row // 4, x // 2] |= _DOTS[row % 4][x % 2]
    labels = [f"{most:9.3g} ", *[" " * 10] * (height - 2), f"{0:9g} "]
    lines = [
        label + "│" + "".join(chr(_BLANK + dots) for dots in row)
        for label, row in zip(labels, cells, strict=True)
    ]
    first, last = f"{wavelengths[0]:g}", f"{wavelengths[-1]:g} nm"
    room = width - len(first) - len(last)
    between = _AXIS.center(room) if len(_AXIS) + 2 <= room else " " * room
    return [*lines, " " * _LABEL + first + between + last]
