"""How a bench is arranged for a reading: target, lamp, angles, polarisers.

Angles are in degrees here, as on the dials of a bench.
"""

from __future__ import annotations

from dataclasses import dataclass

from skinviz._validate import in_range, one_of

WHITE, SAMPLE = "white", "sample"
"""What the meter looks at."""

TARGETS = (WHITE, SAMPLE)

STATES: dict[str, tuple[float | None, float | None]] = {
    "open": (None, None),
    "s": (None, 90.0),
    "p": (None, 0.0),
    "parallel": (45.0, 45.0),
    "crossed": (45.0, 135.0),
}
"""Azimuths of the lamp's polariser and of the analyser, from the plane of incidence;
None where there is none. [degrees]"""


@dataclass(frozen=True)
class Arrangement:
    """A bench as it should stand.

    Attributes
    ----------
    target : {"white", "sample"}
        What the meter looks at.
    lamp : bool
        Whether its light falls on the target.
    illumination : float
        Angle of the lamp from the normal, negative on the viewer's side. [degrees]
    viewing : float
        Angle of the meter from the normal. [degrees]
    state : str
        How the polarisers stand, a key of ``STATES``.
    """

    target: str = WHITE
    lamp: bool = True
    illumination: float = 45.0
    viewing: float = 0.0
    state: str = "open"

    def __post_init__(self) -> None:
        """Refuse what no bench can do."""
        one_of(self.target, TARGETS, "target")
        one_of(self.state, STATES, "state of the polarisers")
        in_range(self.illumination, -85.0, 85.0, "illumination", "degrees")
        in_range(self.viewing, 0.0, 85.0, "viewing", "degrees")
