"""The fine relief of skin: furrows that only tilt its normals."""

from __future__ import annotations

from dataclasses import dataclass

from skinviz._validate import in_range
from skinviz.errors import ArgumentError


@dataclass(frozen=True)
class Relief:
    """Furrows between the small fields of skin, a network in space.

    Where the surface is seen, its normal is tilted as the furrows' sides are; it is
    not moved, and throws no shadow of its own. Without depth it is smooth.

    Attributes
    ----------
    depth : float
        Of the furrows. [µm], 0 to 500
    spacing : float
        Of the furrows. [mm], 0.05 to 50
    seed : int
        Which of all such networks.
    """

    depth: float = 0.0
    spacing: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what no skin has."""
        in_range(self.depth, 0.0, 500.0, "relief depth", "µm")
        in_range(self.spacing, 0.05, 50.0, "relief spacing", "mm")
        object.__setattr__(self, "seed", require_seed(self.seed))


def require_seed(seed: int) -> int:
    """Return a whole number that randomness can start from."""
    in_range(seed, 0, 2**31 - 1, "seed")
    if seed != int(seed):
        raise ArgumentError(f"seed must be a whole number; got {seed!r}")
    return int(seed)


SMOOTH = Relief()
"""No relief."""
