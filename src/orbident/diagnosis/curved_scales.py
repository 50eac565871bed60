"""Suspects that the scale of a sensor depends on what it shows.

A gyro may have another scale where it turns the other way, or at high rates, and a lens
another one at its edge. Of what an axis shows, `y`, the error is

    a |y| + b y |y| / m  of a gyro,    a y^2 / m + b y^3 / m^2  of a position

with `m` the largest that is shown, so that `a` and `b` are errors of scale.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from orbident.diagnosis.shifts import axes_of, less
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.estimation.momentum_problem import MomentumProblem

SMALL = 1e-5
"""Relative: far below what would be seen."""

MOST = 0.1
"""Relative: no instrument's scale changes by more."""


def curved_scales(problem: MomentumProblem) -> Iterator[Suspect]:
    """One of the gyro and one of the position."""
    for sensor in ("gyro", "position"):
        if problem.recording.has(f"{sensor}.x"):
            yield _curved(problem, sensor)


def _curved(problem: MomentumProblem, sensor: str) -> Suspect:
    axes = axes_of(problem, sensor)
    # What it shows along each axis, over the largest.
    along = problem.recording.vector(sensor) @ axes.T
    most = np.nanmax(np.abs(along))
    y = along / most
    even = np.abs(y) if sensor == "gyro" else y**2
    odd = y * even

    def words(c: Numbers) -> str:
        off = np.linalg.norm(c.reshape(2, -1), axis=0).max()
        return (
            f"the scale of the {sensor} depends on what it shows, by up to {off:.2g} "
            + ("(it is not linear)" if sensor == "gyro" else "(as behind a lens)")
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        a, b = c.reshape(2, -1)
        error = most * (even * a + odd * b) @ axes
        # Samples hold only a first guess of the base's motion.
        return replace(problem, recording=less(problem.recording, sensor, error))

    return Suspect(words, np.full(2 * len(axes), SMALL), corrected, MOST)
