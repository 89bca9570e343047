"""What cleaning found and did: its steps, with counts and times."""

from __future__ import annotations

import textwrap
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

Progress = Callable[[str], None]

_WIDTH = 100  # letters
_TOGETHER = "\N{NO-BREAK SPACE}"
_UNITS = {"mm": "mm", "mm2": "mm²"}


@dataclass(frozen=True)
class CleaningStep:
    """One step of cleaning.

    Attributes
    ----------
    name : str
        What was done.
    seconds : float
        How long it took. [s]
    counts : dict
        What was found and changed, by name.
    """

    name: str
    seconds: float
    counts: dict[str, float | int]


@dataclass(frozen=True)
class CleaningReport:
    """What was found and done at each step of cleaning.

    Attributes
    ----------
    steps : tuple of CleaningStep
        In the order they ran.
    """

    steps: tuple[CleaningStep, ...] = field(default=())

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain data for JSON."""
        return asdict(self)

    def __getitem__(self, name: str) -> dict[str, float | int]:
        """Return the counts of the step of that name."""
        for step in self.steps:
            if step.name == name:
                return step.counts
        raise KeyError(name)

    def __str__(self) -> str:
        """Return the report as a table: a row a step, wrapped at 100 letters."""
        label = max((len(step.name) for step in self.steps), default=0)
        rows = []
        for step in self.steps:
            told = _told(step)
            head = f"{step.name:<{label}}  {step.seconds:6.1f} s  "
            lines = textwrap.wrap(
                ", ".join(told),
                _WIDTH,
                initial_indent=head,
                subsequent_indent=" " * len(head),
                break_on_hyphens=False,
            )
            rows += lines or [head.rstrip()]
        # Blanks that must not be wrapped at were kept together until here.
        return "\n".join(rows).replace(_TOGETHER, " ")


@dataclass
class Recorder:
    """Collects the steps while cleaning runs.

    Attributes
    ----------
    progress : callable
        Told the name of each step as it begins.
    steps : list of CleaningStep
        Those that have ended.
    """

    progress: Progress
    steps: list[CleaningStep] = field(default_factory=list)
    _start: float = 0.0

    def begin(self, name: str) -> None:
        """Start the clock of a step and tell its name."""
        self.progress(name)
        self._start = time.perf_counter()

    def end(self, name: str, **counts: float) -> None:
        """Stop the clock of a step and keep its counts."""
        seconds = time.perf_counter() - self._start
        self.steps.append(CleaningStep(name, round(seconds, 3), counts))


def _told(step: CleaningStep) -> list[str]:
    """Return a step's counts, each a word group with its unit after the number."""
    told = []
    for name, value in step.counts.items():
        words = name.split("_")
        unit = _UNITS.get(words[-1])
        said = words[:-1] if unit else words
        told.append(_TOGETHER.join([*said, _number(value), *([unit] if unit else [])]))
    return told


def _number(value: float) -> str:
    """Return a count or a measure as short text."""
    return str(value) if isinstance(value, int) else f"{value:g}"
