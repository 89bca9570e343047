"""What a simulated laser range scanner is like: its geometry and its faults."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skinviz._validate import in_range


@dataclass(frozen=True)
class Scanner:
    """How the simulated scanner samples and errs.

    Attributes
    ----------
    pitch : float
        Distance between neighbouring rays. [mm]
    triangulation_angle : float
        Angle between laser and camera. [rad]
    distance : float
        From the laser to the object's centre; ``inf`` makes the rays parallel. [mm]
    noise : float
        Standard deviation of range at normal incidence and at ``distance``; grows
        with the square of the range and as 1/cos. [mm]
    resolution : float
        Step to which range is rounded. [mm]
    max_incidence : float
        Returns beyond this angle from the normal are lost. [rad]
    min_return : float
        Returns weaker than this are lost; a white point that faces the laser at
        ``distance`` returns 1, others albedo · cos / (range / distance)². [1]
    spike : float
        Mean length of the spikes at depth edges. [mm]
    spike_fraction : float
        Share of the points beside a depth edge that spike.
    outlier_fraction : float
        Share of all points replaced by a stray range.
    pose_shift : float
        Standard deviation of each component of a pose's translation error. [mm]
    pose_tilt : float
        Standard deviation of each component of a pose's rotation error. [rad]
    """

    pitch: float = 0.8
    triangulation_angle: float = np.deg2rad(20)
    distance: float = np.inf
    noise: float = 0.1
    resolution: float = 0.01
    max_incidence: float = np.deg2rad(75)
    min_return: float = 0.0
    spike: float = 2.0
    spike_fraction: float = 0.3
    outlier_fraction: float = 0.001
    pose_shift: float = 0.5
    pose_tilt: float = np.deg2rad(0.3)

    def __post_init__(self) -> None:
        """Refuse what no scanner could be."""
        in_range(self.pitch, 1e-3, 1e3, "pitch", "mm")
        in_range(self.triangulation_angle, 0, np.pi / 3, "triangulation angle", "rad")
        in_range(self.max_incidence, 0, np.pi / 2, "max incidence", "rad")
        in_range(self.distance, 1e-3, np.inf, "distance", "mm")
        for name in ("noise", "resolution", "spike", "pose_shift", "pose_tilt"):
            in_range(getattr(self, name), 0, 1e3, name)
        for name in ("spike_fraction", "outlier_fraction", "min_return"):
            in_range(getattr(self, name), 0, 1, name)

    @property
    def baseline(self) -> float:
        """Distance from the laser to the camera. [mm]"""
        return float(self.distance * np.tan(self.triangulation_angle))
