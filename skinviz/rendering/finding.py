"""What planning found of one knob, and how that is told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One knob's choice.

    Attributes
    ----------
    knob : str
        Its name.
    chosen : str
        The level chosen, in words.
    left_out : str
        What the reference has beyond it; empty where nothing.
    delta_e : float or None
        What leaving it out changes, everything else exact: 99.9 % bound on the 99th
        percentile over the pixels that the mesh fills. 0 where it is exact by
        construction, None where it was not worth finding out. [ΔE00]
    saved : float
        Time that the choice saves, by this machine's rates. [ms]
    refused : str
        The next cheaper level, that would have changed too much; empty where there is
        none or none was tried.
    refused_delta_e : float or None
        What that would have changed; None where nothing could be said of it. [ΔE00]
    """

    knob: str
    chosen: str
    left_out: str = ""
    delta_e: float | None = None
    saved: float = 0.0
    refused: str = ""
    refused_delta_e: float | None = None

    def __post_init__(self) -> None:
        """Keep no infinity, which JSON cannot hold."""
        if self.refused_delta_e is not None and not math.isfinite(self.refused_delta_e):
            object.__setattr__(self, "refused_delta_e", None)


_HEAD = ("knob", "chosen", "left out", "ΔE00", "saved", "too coarse")
_RIGHT = (False, False, False, True, True, False)


def told_table(tolerance: float | None, findings: Sequence[Finding]) -> str:
    """Return findings as a table with a line each."""
    if not findings:
        return "not planned: every setting is as it was given"
    rows = [_row(finding) for finding in findings]
    widths = [max(map(len, column)) for column in zip(_HEAD, *rows, strict=True)]
    lines = [
        "  ".join(
            cell.rjust(width) if right else cell.ljust(width)
            for cell, width, right in zip(row, widths, _RIGHT, strict=True)
        ).rstrip()
        for row in (_HEAD, *rows)
    ]
    return "\n".join([f"tolerance ΔE00 {tolerance:g}", *lines])


def _row(finding: Finding) -> tuple[str, ...]:
    """Return the cells of one finding."""
    refused = finding.refused
    if finding.refused_delta_e is not None:
        refused = f"{refused}: {_told_difference(finding.refused_delta_e)}"
    return (
        finding.knob,
        finding.chosen,
        finding.left_out or "nothing",
        "-" if finding.delta_e is None else _told_difference(finding.delta_e),
        f"{finding.saved:.0f} ms" if finding.saved > 0.5 else "-",
        refused,
    )


def _told_difference(delta_e: float) -> str:
    """Return a colour difference in as many digits as matter."""
    return (
        "0" if delta_e == 0 else f"{delta_e:.3f}" if delta_e < 10 else f"{delta_e:.0f}"
    )
