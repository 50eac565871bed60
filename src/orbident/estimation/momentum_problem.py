"""What every estimator is given: a recording, made ready, and what is known of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.linear_fits import (
    Fits,
    InitialMomentum,
    fit,
    known_momentum,
    rest_std,
)
from orbident.estimation.mass import Mass, mass_of
from orbident.files.kept_pieces import KeptPieces
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.delays import Delay, base_clocks, corrections
from orbident.preprocessing.extent import Extent
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import screened
from orbident.preprocessing.smoothing import Settings
from orbident.recordings.long_recording import LARGE
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

ROUNDING = 1e-7
"""Residuals over the signal: what integration and float32 leave."""


class OutsideMomentum(NamedTuple):
    """What acted from outside has given to the momenta since the first row."""

    t: Float[np.ndarray, " nodes"]
    """s."""
    h: Float[np.ndarray, "nodes 3"]
    """To the angular momentum about the system CM, inertial axes, N m s."""
    v: Float[np.ndarray, "nodes 3"]
    """To the velocity of the system CM, inertial axes, m/s."""


@dataclass(frozen=True)
class MomentumProblem:
    """A robot, its recording on settled clocks, and both linear fits of it."""

    robot: Robot
    sets: MinimalSets
    recording: Recording
    """Without samples that cannot be true."""
    rejected: Mapping[str, Mapping[str, int]]
    """How many samples were left out, by column and reason."""
    notes: tuple[str, ...]
    """What is odd about it, and was left as it is."""
    clocks: Mapping[str, Delay]
    """How far each sensor's clock is behind that of the base rate."""
    samples: Samples
    initial_momentum: InitialMomentum
    fits: Fits
    """Eqs. 24 and 31, each for itself: where every search starts."""
    extent: Extent | None = None
    """What all samples span, where `recording` and `samples` are those of a digest."""
    pieces: KeptPieces | None = None
    """All samples then, packed, where an estimator needs them again."""

    @property
    def late(self) -> dict[str, float]:
        """How far each sensor's clock is taken to be behind, s."""
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

    @property
    def rest_std(self) -> Float[np.ndarray, "3"] | None:
        """Deviations of the momentum if the robot is said to be at rest, N m s."""
        if self.initial_momentum != "at-rest":
            return None
        return rest_std(self.robot, self.fits.h_rw / np.sqrt(self.samples.t.size))

    @property
    def exact(self) -> bool:
        """Whether the linear fits leave no more than integration and float32 do."""
        if self.samples.unknown_thrust:
            # Without its momentum no parameters at all may fit.
            return False
        fits = self.fits.pi, self.fits.phi
        return all(fit.unexplained <= ROUNDING * fit.explained for fit in fits)

    def beginning(self, samples: int) -> "MomentumProblem":
        """The problem of its first samples, so many at most."""
        recording = self.recording
        if recording.t.size <= samples:
            return self
        columns = {name: x[:samples] for name, x in recording.columns.items()}
        return self.amended(
            recording=replace(recording, t=recording.t[:samples], columns=columns)
        )

    def without(self, given: OutsideMomentum) -> "MomentumProblem":
        """The problem of the same motion, without what acts from outside."""
        samples = self.samples.without(given.t, given.h, given.v)
        fits = fit(
            self.robot, self.sets, samples, self.initial_momentum, lambda _: None
        )
        return replace(self, samples=samples, fits=fits)

    def amended(
        self,
        robot: Robot | None = None,
        recording: Recording | None = None,
        pushed: tuple[float, float] | None = None,
    ) -> "MomentumProblem":
        """This problem with another robot file, recording or push; its clocks stay."""
        robot = robot or self.robot
        same = robot.joints is self.robot.joints
        changed = replace(
            self,
            robot=robot,
            sets=self.sets if same else minimal_sets(robot),
            recording=recording or self.recording,
        )
        again = on_clocks(changed, self.clocks)
        known = pushed or self.samples.pushed
        return replace(again, samples=replace(again.samples, pushed=known))


def momentum_problem(
    robot: Robot,
    recording: Recording,
    initial_momentum: InitialMomentum,
    progress: Callable[[float], object],
    settings: Settings | None = None,
) -> MomentumProblem:
    """Screen a recording, settle its clocks, and derive what it lacks.

    Args:
        robot: geometry, wheels and structure.
        recording: of the free-floating robot.
        initial_momentum: what is known of the momentum.
        progress: is called with the fraction of the samples that is done.
        settings: how its columns are smoothed, where it is a digest.

    Returns:
        The problem, on the clock of the attitude that the gyro shows.

    Raises:
        InputError: a column is missing, there are too few samples, or the nominal mass
            matrix is singular.
    """
    check_regular(robot)
    clean = screened(robot, recording.with_joints_of(robot))
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, clean.recording)
    samples = samples_of(robot, clean.recording, corrections(clocks), settings)
    fits = fit(robot, sets, samples, initial_momentum, progress)
    if recording.t.size >= LARGE:
        _core.give_back_memory()
    return MomentumProblem(
        robot,
        sets,
        clean.recording,
        clean.rejected,
        clean.notes,
        clocks,
        samples,
        initial_momentum,
        fits,
    )


def on_clocks(problem: MomentumProblem, clocks: Mapping[str, Delay]) -> MomentumProblem:
    """The same recording on other clocks."""
    robot, given = problem.robot, problem.initial_momentum
    samples = samples_of(robot, problem.recording, corrections(clocks))
    fits = fit(robot, problem.sets, samples, given, lambda _: None)
    return replace(
        problem,
        clocks=clocks,
        samples=samples,
        fits=fits,
        extent=None,
        pieces=None,
    )
