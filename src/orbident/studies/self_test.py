"""Whether an installation works: the paper's robot, simulated and identified."""

import time
from dataclasses import dataclass

import numpy as np

from orbident.estimation.identify import identify
from orbident.estimation.least_squares import LeastSquares
from orbident.simulation.simulate import simulate
from orbident.studies.spatial import spatial_robot, spatial_trajectory

LARGEST_ERROR = 1e-6
"""Relative. Without noise only rounding is left, some 1e-14."""


@dataclass(frozen=True)
class SelfTest:
    """What came out."""

    robot: str
    parameters: int
    error: float
    """The largest error of a base parameter, relative to the true value."""
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every parameter was found."""
        # Not a number is no small error.
        return bool(self.error < LARGEST_ERROR)


def self_test() -> SelfTest:
    """Identifies the bundled robot of the paper's spatial study, without noise."""
    start = time.monotonic()
    robot = spatial_robot()
    recording = simulate(robot, spatial_trajectory(robot))
    base = identify(robot, recording, LeastSquares()).base
    scale = np.where(base.nominal == 0, np.abs(base.nominal).max(), base.nominal)
    error = float(np.max(np.abs((base.values - base.nominal) / scale)))
    return SelfTest(robot.name, len(base.names), error, time.monotonic() - start)
