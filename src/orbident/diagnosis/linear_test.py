"""Which convention makes the linear equations 24 and 31 fit best."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.diagnosis.conventions import (
    Convention,
    conventions,
    felt_alone,
    of_accelerometer,
)
from orbident.diagnosis.torque_columns import plain_torques
from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.estimate import whiteness
from orbident.estimation.linear_fits import Fits, LinearFit, fit
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.obstacles import no_motion, obstacles
from orbident.estimation.signals import equation_signals

ROWS = 1000
"""So many samples from the beginning of a recording show a wrong convention as well as
all of them do."""

FALLS = 2.0
"""Times that the residuals of both equations together must be smaller."""

ABSURD = 0.05
"""Part of the momentum, or of the velocity of S, that the linear equations leave where
something is plainly wrong: noise is some thousandths, and CAD does not enter. A sign on
a table leaves 0.07; below that, conventions are tried only after a fit: it takes a
second."""

PLAIN = 12.0
"""Times that what lasts of residuals is smaller with a plain mistake put right. Of 384
recordings the best convention of none made it between 1.5 and 100 times smaller; of
windows in which the base hardly moves a false one made it 8 times smaller, and a true
one 16 times beside noise of the gyro that is as large as half of the motion."""

HARDLY = 0.9
"""Times: a convention that leaves larger residuals than as recorded is none."""

PLAINLY = 1.1
"""Times better than a simpler suspicion, which comes before."""

UNLIKELY = 1e3
"""Times that residuals count where `pi` or `phi` is far from the nominal one: a gain
leaves the residuals as they are."""

TINY = 1e-300

SAME = 1e-6
"""Relative: residuals that differ by less differ by rounding alone."""

FARTHEST = 5.0
"""Times: bodies are known better than that before they are built."""

AS_CAD = 1.5
"""Times: all bodies together are known as well before they are built. What a linear
equation finds too small, as noise in its columns does, is no size that CAD has."""

LIKE_CAD = 0.9
"""Cosine between what an equation shows and what CAD says: 0.94 and more where CAD is
30 % off. Of noise, or of a CM that is elsewhere, a size says nothing."""


class CorrectedConvention(NamedTuple):
    """A convention, put right."""

    convention: Convention
    falls: float
    """The residuals as recorded, over those with the convention put right."""
    residuals_alone: float
    """The same, whether or not parameters are of a likely sign and size."""
    as_cad: bool
    """Whether parameters are of the size that CAD has, and far from it as recorded."""

    def or_one_of(
        self, others: Iterable["CorrectedConvention"]
    ) -> "CorrectedConvention":
        """This convention, in words with the first other one that fits as well."""
        for one in others:
            other = one.convention.cause != self.convention.cause
            alike = math.isclose(one.falls, self.falls, rel_tol=SAME)
            if other and alike and one.as_cad == self.as_cad:
                cause = f"{self.convention.cause}, or {one.convention.cause}"
                return self._replace(convention=replace(self.convention, cause=cause))
        return self

    def check(self) -> Check:
        """What refuses the recording, in words."""
        times = f"{self.residuals_alone:.2g}"
        shown = (
            f"the residuals of Eqs. 24 and 31 are {times} times smaller"
            if self.residuals_alone > FALLS
            else "the parameters are of the size that CAD has"
        )
        # A gain leaves residuals as they are.
        perhaps = "" if self.residuals_alone > FALLS else "perhaps "
        return Check(
            "cause",
            "do not trust",
            f"{perhaps}{self.convention.cause}: with that corrected {shown}",
            "correct the recording or the robot file",
            self.falls,
        )


def tried_conventions(problem: MomentumProblem) -> list[CorrectedConvention]:
    """Each convention with the factor by which it lowers the residuals, best first.

    A later one counts only where it is plainly better than all before.
    """
    part = problem.beginning(ROWS)
    felt = felt_alone(part)
    found = [_corrected(part, one) for one in conventions(part)]
    found += [_corrected(felt, of_accelerometer())] if felt else []
    best, worth = 0.0, {}
    for k, one in enumerate(found):
        if one.falls > PLAINLY * best:
            best = one.falls
            worth[k] = one
    others = [one for k, one in enumerate(found) if k not in worth]
    first = sorted(worth.values(), key=lambda one: -one.falls)
    rest = sorted([*first[1:], *others], key=lambda one: -one.falls)
    return [*(one.or_one_of(rest) for one in first[:1]), *rest]


def _corrected(part: MomentumProblem, convention: Convention) -> CorrectedConvention:
    """What putting it right brings."""
    before, left = _left(part, part.fits), _misfit(part, convention)
    falls = before.misfit / left.misfit if left.misfit > 0 else 0.0
    alone = before.residuals / left.residuals if left.residuals > 0 else 0.0
    falls = falls if alone > HARDLY else min(falls, alone)
    # A gain leaves residuals as they are, and all else makes them smaller.
    explains = alone > FALLS or math.isclose(alone, 1.0, rel_tol=SAME)
    as_cad = explains and before.far > 0 and left.as_cad
    return CorrectedConvention(convention, falls, alone, as_cad)


def plain_mistake(problem: MomentumProblem) -> list[Check]:
    """What is plainly written otherwise, which no fit is needed to see."""
    return _plain_convention(problem) or plain_torques(problem)


def _plain_convention(problem: MomentumProblem) -> list[Check]:
    """A convention that is plainly another one."""
    fits = problem.fits
    # What springs let swing is little beside a plain mistake, and thrust is not.
    if problem.samples.unknown_thrust or not problem.scale_seen or no_motion(problem):
        return []
    left = np.array([_part_left(fits.pi), _part_left(fits.phi)])
    absurd = left > ABSURD
    if absurd.any():
        absurd &= 1 - _correlations(problem) < 1 / FALLS**2
    if not absurd.any() and not _left(problem, fits).far:
        return []
    best, *_ = tried_conventions(problem)
    # Of a robot that was not at rest, as was said, the scale is wrong by itself.
    moving = any(one.name == "at rest" for one in obstacles(problem))
    plain = _lasting_falls(problem, best) > PLAIN or (best.as_cad and not moving)
    return [best.check()] if plain else []


def _lasting_falls(problem: MomentumProblem, best: CorrectedConvention) -> float:
    """How many times smaller what lasts of the residuals is with a convention right."""
    if best.residuals_alone < FALLS:
        return best.residuals_alone
    left = [problem, problem.amended(recording=best.convention.written(problem))]
    before, after = map(_lasting_part, left)
    return before / after if after > 0 else np.inf


def _lasting_part(problem: MomentumProblem) -> float:
    """The part that both equations leave, without noise of single samples."""
    fits, lasting = problem.fits, np.sqrt(_correlations(problem))
    return math.prod(
        _part_left(fit) * float(part)
        for fit, part in zip((fits.pi, fits.phi), lasting, strict=True)
        if fit.explained > 0
    )


def _part_left(fit: LinearFit) -> float:
    """The part of what a linear equation should explain that it leaves."""
    whole = float(np.hypot(fit.explained, fit.unexplained))
    return fit.unexplained / whole if whole > 0 else 0.0


def _correlations(problem: MomentumProblem) -> Float[np.ndarray, "2"]:
    """Those of neighbouring residuals of Eqs. 24 and 31: the part that is no noise.

    No convention lowers noise of single samples, which differs from one to the next
    (von Neumann 1941). Less than white noise has by chance says nothing of what lasts.
    """
    fits, parts = problem.fits, {"momentum": 1.0, "velocity": 1.0}
    for signal in equation_signals(
        *(problem.robot, problem.sets, problem.samples, problem.initial_momentum),
        *(fits.pi.values, fits.phi.values),
    ):
        left = signal.measured - signal.predicted
        parts[signal.name] = max(whiteness(left), len(left) ** -0.5)
    return np.array([*parts.values()])


class _Left(NamedTuple):
    """What the linear equations leave."""

    residuals: float
    """Over all that there is to explain, of both equations."""
    gains: tuple[float, ...] = ()
    """How many times those of CAD `pi` and `phi` are."""
    cosines: tuple[float, ...] = ()
    """Between these and those of CAD."""

    @property
    def far(self) -> int:
        """How many of both are of an unlikely sign or size."""
        return sum(not 1 / FARTHEST < gain < FARTHEST for gain in self.gains)

    @property
    def as_cad(self) -> bool:
        """Whether both are as CAD has them, of that size."""
        sized = all(1 / AS_CAD < gain < AS_CAD for gain in self.gains)
        return sized and all(each > LIKE_CAD for each in self.cosines)

    @property
    def misfit(self) -> float:
        return self.residuals * UNLIKELY**self.far


def _misfit(problem: MomentumProblem, convention: Convention) -> _Left:
    try:
        samples = convention.amended(problem)
        robot, sets, given = problem.robot, problem.sets, problem.initial_momentum
        return _left(problem, fit(robot, sets, samples, given, lambda _: None))
    except InputError:
        return _Left(np.inf)


def linear_misfit(problem: MomentumProblem) -> float:
    """Residuals over all that there is to explain, more where parameters are unlikely.

    Args:
        problem: with its linear fits.
    """
    return _left(problem, problem.fits).misfit


def _left(problem: MomentumProblem, fits: Fits) -> _Left:
    robot, sets = problem.robot, problem.sets
    by_cad = sets.pi(robot.theta), sets.phi(robot.theta)
    # Without positions the equation of the velocity is empty, and says nothing.
    found = [
        (_part_left(fit), *_gain(fit, nominal))
        for fit, nominal in zip((fits.pi, fits.phi), by_cad, strict=True)
        if fit.explained > 0
    ]
    if not np.isfinite(found).all():
        return _Left(np.inf)
    left, gains, cosines = zip(*found, strict=True) if found else ((), (), ())
    return _Left(math.prod(left), gains, cosines)


def _gain(found: LinearFit, nominal: Float[np.ndarray, " n"]) -> tuple[float, float]:
    """How many times CAD's values explain most, and the cosine between the two.

    Both are negative where they are opposite. All other changes are held, so that the
    motion need not show each of them.
    """
    by_cad, shown = found.factor @ nominal, found.target
    size, both = float(np.linalg.norm(by_cad)), float(by_cad @ shown)
    cosine = both / max(size * float(np.linalg.norm(shown)), TINY)
    return both / max(size**2, TINY), cosine
