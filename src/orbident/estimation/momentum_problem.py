"""What every estimator is given: a recording, made ready, and what is known of it.

A long recording is read in stretches. What only the whole can tell is found from a
digest of it: clocks, how rough and how noisy each column is, what is measured and what
is derived. Then the equations of all its samples are folded into one triangular factor,
in one pass.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import chdtri

from orbident.estimation.base_parameters import Mass, mass_of
from orbident.estimation.linear_fits import (
    Factors,
    Fits,
    InitialMomentum,
    LinearEquations,
    fit,
    known_momentum,
    rest_std,
)
from orbident.model.core_robot import wheels_of
from orbident.model.equations_of_motion import check_regular
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.preprocessing.delays import Delay, base_clocks, check_seconds, corrections
from orbident.preprocessing.extent import Extent
from orbident.preprocessing.origins import RUNNING
from orbident.preprocessing.samples import OutsideMomentum, Samples, samples_of
from orbident.preprocessing.screening import cleaned, screened
from orbident.preprocessing.smoothing import LONGEST, Settings
from orbident.preprocessing.stretches import (
    KeptPieces,
    Part,
    Piece,
    Stretches,
    packed_piece,
    smoothed_rate,
    some_rows,
    trusted,
)
from orbident.recordings.long_recording import LongRecording, spare_memory
from orbident.recordings.no_measurements import NO_SENSORS
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

STEADY = 1e-6
"""Where wheels turn steadily, the known term of the momentum equation, nuisance apart,
beside all of it: encoders of 0.2 mrad at 200 rad/s leave up to 5e-8 after smoothing, as
slow as arms move, which parameters may explain by chance."""

EXPLAINED = 0.9
"""What the parameters must explain of it, squared: noise is explained hardly at all,
and signals in wrong units or frames in part."""

STANDS = 1e-3
"""rad/s: a wheel that is slower stands, and its encoder shows noise."""

VARIES = 1e-2
"""Below this part of the wheels' momentum it may be noise of their speeds."""

RARE = 1e-3
"""How rarely noise of wheels' speeds alone passes for momentum that varies."""

ROUNDING = 1e-7
"""Residuals over the signal: what integration and float32 leave."""


@dataclass(frozen=True)
class MomentumProblem:
    """A robot, and its recording on settled clocks."""

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
    known_fits: Fits | None = None
    """What `fits` are, where they are known."""
    extent: Extent | None = None
    """What all samples span, where `recording` and `samples` are those of a digest."""
    pieces: KeptPieces | None = None
    """All samples then, packed, where an estimator needs them again."""

    @property
    def late(self) -> dict[str, float]:
        """How far each sensor's clock is taken to be behind, s."""
        return corrections(self.clocks)

    @cached_property
    def fits(self) -> Fits:
        """Eqs. 24 and 31, each for itself: where every search starts.

        Raises:
            InputError: there are too few samples for one of them.
        """
        if self.known_fits is not None:
            return self.known_fits
        given = self.initial_momentum
        return fit(self.robot, self.sets, self.samples, given, lambda _: None)

    @property
    def linear(self) -> bool:
        """Whether linear equations know all that moves it: no thrust, no springs."""
        return not (self.samples.unknown_thrust or self.robot.passive)

    @property
    def scale_seen(self) -> bool:
        """Whether the wheels' momentum shows how large all parameters are."""
        pi, h_rw = self.fits.pi, self.fits.h_rw
        known = float(np.hypot(pi.explained, pi.unexplained))
        # Where it varies by more, a torque may hide that they explain it: the fit
        # decides.
        chance = chdtri(pi.values.size, RARE) * self._speed_noise**2
        unexplained = pi.explained**2 <= max(EXPLAINED * known**2, chance)
        turning = (np.nanmean(np.square(x)) for x in self.samples.qd_rw if x.size)
        steady = known <= STEADY * h_rw or max(turning, default=0.0) < STANDS**2
        return not (steady or (known <= VARIES * h_rw and unexplained))

    @property
    def _speed_noise(self) -> float:
        """Std of the wheels' momentum in a row by the noise of tachometers, N m s.

        Smoothing leaves all of it in what is as slow as arms, which parameters explain.
        """
        dt = float(np.diff(self.samples.t).mean())
        std = [x.white or x.density / np.sqrt(dt) for x in self.samples.speeds]
        return float(np.linalg.norm(wheels_of(self.robot).A_rw * (std or [0.0]), 2))

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
        return self.amended(recording=recording.some(slice(samples)))

    def without(self, given: OutsideMomentum) -> "MomentumProblem":
        """The problem of the same motion, without what acts from outside."""
        return replace(self, samples=self.samples.without(given), known_fits=None)

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
        InputError: a column is missing, times are not in seconds, there are too few
            samples, or the nominal mass matrix is singular.
    """
    check_regular(robot)
    check_seconds(robot, recording)
    clean = screened(robot, recording.with_joints_of(robot))
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, clean.recording)
    samples = samples_of(robot, clean.recording, corrections(clocks), settings)
    fits = fit(robot, sets, samples, initial_momentum, progress)
    spare_memory(recording.t.size)
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
    return replace(
        problem,
        clocks=clocks,
        samples=samples_of(problem.robot, problem.recording, corrections(clocks)),
        known_fits=None,
        extent=None,
        pieces=None,
    )


def digest_of(
    robot: Robot, recording: LongRecording, initial_momentum: InitialMomentum
) -> MomentumProblem | None:
    """As `momentum_problem`, of a digest of the recording.

    Returns:
        None where something must be integrated over the whole recording, so that it
        has to be in memory.

    Raises:
        InputError: as `momentum_problem`.
    """
    heads = {name.partition(".")[0] for name in recording.digest.columns}
    if heads & {"thruster", *NO_SENSORS}:
        return None
    problem = momentum_problem(
        robot, recording.digest, initial_momentum, lambda _: None, Settings(LONGEST)
    )
    if any(origin & RUNNING for origin in problem.samples.origins.values()):
        return None
    return problem


def whole(
    problem: MomentumProblem,
    recording: LongRecording,
    again: bool,
    progress: Callable[[float], object],
    size: int | None = None,
) -> MomentumProblem:
    """The problem of all samples, on the clocks that it has.

    Args:
        problem: of a digest.
        recording: the whole of it.
        again: whether an estimator needs all samples again.
        progress: is called with the fraction of the rows that is done.
        size: rows of a stretch, where not as many as fit into memory.

    Returns:
        The problem whose recording and samples are those of the digest, and whose
        linear fits are of all samples.

    Raises:
        InputError: as `momentum_problem`.
    """
    robot, settings = problem.robot, Settings(LONGEST)
    late = corrections(problem.clocks)
    every = Stretches(robot, recording, late, settings, size or recording.stretch)
    # Joints that never move are held; which these are is known after one pass.
    settings.locked = {}
    # Which angles are shown within a turn, and which rates are false.
    cleaned(robot, recording.digest, settings)
    while True:
        samples = samples_of(robot, problem.recording, late, settings)
        # Those of before are held no longer.
        problem = replace(problem, samples=samples)
        if again:
            smoothed_rate(samples, settings)
        equations = LinearEquations.of(
            robot, problem.sets, samples, problem.initial_momentum
        )
        spare_memory(recording.rows)
        one_pass = _Pass(every, equations, trusted(samples) if again else None)
        pieces = KeptPieces(one_pass.pieces) if again else None
        total = None
        for seen, piece in one_pass():
            total = total.and_of(seen) if total else seen
            if pieces and piece:
                pieces.keep(piece)
            progress(total.extent.rows / recording.rows)
        assert total is not None
        locked = total.extent.locked(robot)
        if settings.locked or not locked:
            break
        settings.locked = locked
    return replace(
        problem,
        known_fits=equations.solved(robot, problem.sets, samples, total.factors),
        extent=total.extent,
        pieces=pieces,
        rejected=total.rejected_by_column(),
    )


@dataclass(frozen=True)
class _Pass:
    """One pass through a recording, as often as it is called."""

    stretches: Stretches
    equations: LinearEquations
    trusted: tuple[float, float] | None
    """Between these times samples are packed, s."""

    def __call__(self) -> Iterator[tuple["_Seen", Piece | None]]:
        """What each stretch says, and its packed samples."""
        return self.stretches.each(lambda part: (self._seen(part), self._piece(part)))

    def pieces(self) -> Iterator[Piece]:
        """The packed samples alone."""
        return (piece for piece in self.stretches.each(self._piece) if piece)

    def _seen(self, part: Part) -> "_Seen":
        own = some_rows(part.samples, part.own)
        rejected = Counter(
            {
                (column, why): count
                for column, reasons in part.rejected.items()
                for why, count in reasons.items()
            }
        )
        return _Seen(self.equations.folded(own), Extent.of(own), rejected)

    def _piece(self, part: Part) -> Piece | None:
        if self.trusted is None:
            return None
        rate = smoothed_rate(part.samples, self.stretches.settings)[part.own]
        return packed_piece(some_rows(part.samples, part.own), rate, self.trusted)


class _Seen(NamedTuple):
    """What the samples of some stretches amount to."""

    factors: Factors
    extent: Extent
    rejected: Counter[tuple[str, str]]
    """How many samples were left out, by column and reason."""

    def and_of(self, other: "_Seen") -> "_Seen":
        """What both do, the other being later."""
        return _Seen(
            self.factors.and_of(other.factors),
            self.extent.and_of(other.extent),
            self.rejected + other.rejected,
        )

    def rejected_by_column(self) -> dict[str, dict[str, int]]:
        """How many samples were left out of each column, by reason."""
        found: dict[str, dict[str, int]] = {}
        for (column, reason), count in self.rejected.items():
            found.setdefault(column, {})[reason] = count
        return found
