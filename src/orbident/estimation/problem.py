"""What every estimator is given: a recording, made ready, and what is known of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from orbident.estimation.clocks import base_clocks, joint_clocks
from orbident.estimation.linear_fits import (
    Fits,
    InitialMomentum,
    fit,
    known_momentum,
)
from orbident.estimation.mass import Mass, mass_of
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.delays import Delay, corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


@dataclass(frozen=True)
class MomentumProblem:
    """A robot, its recording on settled clocks, and both linear fits of it."""

    robot: Robot
    sets: MinimalSets
    recording: Recording
    """Without samples that cannot be true."""
    rejected: Mapping[str, Mapping[str, int]]
    """By column and reason, how many samples were left out."""
    clocks: Mapping[str, Delay]
    """By sensor, by how much its clock is behind that of the base rate."""
    samples: Samples
    initial_momentum: InitialMomentum
    fits: Fits
    """Eqs. 24 and 31, each for itself: where every search starts."""

    @property
    def late(self) -> dict[str, float]:
        """By sensor, by how much its clock is taken to be behind, s."""
        return corrections(self.clocks)

    @cached_property
    def linear_mass(self) -> Mass:
        """The mass by Eq. 32, from the linear fits."""
        return mass_of(self.sets, self.fits.pi, self.fits.phi)

    @cached_property
    def h_cm(self) -> Float[np.ndarray, "3"] | None:
        """The momentum, where more than the first sample says it; N m s."""
        if self.initial_momentum != "at-rest":
            return None
        known = known_momentum(self.robot, self.sets, self.samples, "at-rest")
        return None if known is None else np.asarray(known.h)


def momentum_problem(
    robot: Robot,
    recording: Recording,
    initial_momentum: InitialMomentum,
    progress: Callable[[float], object],
) -> MomentumProblem:
    """Screen a recording, settle its clocks, and derive what it lacks.

    Args:
        robot: geometry, wheels and structure.
        recording: of the free-floating robot.
        initial_momentum: what is known of the momentum.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: a column is missing, there are too few samples, or the nominal mass
            matrix is singular.
    """
    check_regular(robot)
    recording.check_joints(robot)
    clean = screened(robot, recording)
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, clean.recording)
    samples = samples_of(robot, clean.recording, corrections(clocks))
    fits = fit(robot, sets, samples, initial_momentum, progress)
    clocks |= joint_clocks(robot, sets, samples, initial_momentum)
    if "joints" in clocks and clocks["joints"].believed:
        samples = samples_of(robot, clean.recording, corrections(clocks))
        fits = fit(robot, sets, samples, initial_momentum, progress)
    return MomentumProblem(
        robot,
        sets,
        clean.recording,
        clean.rejected,
        clocks,
        samples,
        initial_momentum,
        fits,
    )
