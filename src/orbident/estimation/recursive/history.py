"""A whole recording through the filter: how its estimate came about, what changed.

Sample by sample, with a watch for changes of the robot.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.estimate import (
    Estimate,
    Goodness,
    Progress,
    biases_of_sensors,
    estimate_of_beta,
    rms_of_equations,
)
from orbident.estimation.found import BetaEstimate
from orbident.estimation.levels import LEVELS
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursion import Change, History
from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended, State
from orbident.estimation.recursive.given import Given, given_of
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    cad_covariance,
    cad_prior,
)
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

PART = 1024
"""Samples between two reports of progress."""

LEARNT = 0.5
"""Below this part of what it was beforehand, an uncertainty comes from the samples."""


class FilterHistory(NamedTuple):
    """What the filter makes of every sample, with or without a scale."""

    beta: Float[np.ndarray, "n beta"]
    std: Float[np.ndarray, "n beta"]
    tests: Float[np.ndarray, "n 4"]
    """Innovation squared, its degrees of freedom, the detector's statistic, and 0 for
    a sample that counts."""
    changes: tuple[Change, ...]
    scale: bool
    """Whether the wheels' momentum told the scale."""
    last: State


def recursive_history(
    robot: Robot,
    samples: Samples,
    h_cm: Float[np.ndarray, "3"] | None = None,
    false_alarms: float = LEVELS["change"],
    progress: Callable[[float], object] = lambda _: None,
) -> History:
    """Estimate sample by sample, watch for changes, and open up after one.

    Args:
        robot: the filter starts from its nominal inertia, with 30 % uncertainty.
        samples: of a recording.
        h_cm: the momentum where it is known, inertial axes, N m s.
        false_alarms: probability of one in this recording if nothing changes.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: no sample is complete.
    """
    given = given_of(robot, samples)
    prior, t = cad_prior(robot), given.t
    kalman = Extended.of(robot, given.noise)
    detector = Detector(kalman.rows, false_alarms=false_alarms, samples=t.size)
    at = filter_history(robot, kalman, detector, given, h_cm, progress)
    unknown = 0.0 if at.scale else np.nan
    nis, dof, statistic, _ = at.tests.T
    pi, phi = zip(*(kalman.sets.pi_and_phi(row) for row in at.beta), strict=True)
    beforehand = np.linalg.norm(np.linalg.inv(prior.root), axis=1)
    covariance = at.last.covariance
    return History(
        t=t,
        beta=at.beta + unknown,
        std=at.std + unknown,
        pi=np.array(pi) + unknown,
        phi=np.array(phi),
        M=at.beta[:, 0] + unknown,
        nis=nis,
        dof=dof,
        statistic=statistic / detector.threshold,
        changes=at.changes if at.scale else (),
        covariance=covariance,
        determined=(at.std[-1] < LEARNT * beforehand) & at.scale,
        scale=at.scale,
        declared=given.noise.declared,
        biases=kalman.biases(at.last, at.last.beta, covariance),
    )


def filter_history(
    robot: Robot,
    kalman: Extended,
    detector: Detector,
    given: Given,
    h_cm: Float[np.ndarray, "3"] | None,
    progress: Callable[[float], object] = lambda _: None,
) -> FilterHistory:
    """Take all samples in, one by one, and open up after every change.

    Args:
        robot: whose nominal inertia is the prior, with 30 % uncertainty.
        kalman: its filter.
        detector: of changes.
        given: the samples.
        h_cm: the momentum where it is known, inertial axes, N m s.
        progress: is called with the fraction of the samples that is done.
    """
    t, every, opening = given.t, given.samples, cad_covariance(robot, UNCERTAINTY)
    state = kalman.begun(cad_prior(robot), every[0], h_cm)
    watch, parts, changes, scale, done = detector.start(), [], [], False, 0
    while done < t.size:
        progress(done / t.size)
        part = slice(done, done + PART)
        after, watch, count, onset, beta, std, tests = kalman.core.run(
            state.core, watch, detector.threshold, t[part], every[part]
        )
        state, done = State(after), done + count
        parts.append((beta[:count], std[:count], tests[:count]))
        if onset is not None:
            changes.append(
                detector.change(float(t[done - 1]), onset, float(tests[count - 1, 2]))
            )
            scale |= kalman.core.scaled(state.core, robot.mass)
            state, watch = kalman.opened(state, opening), detector.start()
            std[count - 1] = np.sqrt(np.diag(state.covariance))
    beta, std, tests = map(np.concatenate, zip(*parts, strict=True))
    scale |= kalman.core.scaled(state.core, robot.mass)
    return FilterHistory(beta, std, tests, tuple(changes), scale, state)


@dataclass(frozen=True)
class Recursive:
    """The information filter from CAD values, which it takes to be uncertain by 30 %.

    The estimate is that after the last sample.
    """

    name: str = "recursive"

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Take the samples one by one.

        Raises:
            InputError: no sample is complete.
        """
        robot, samples = problem.robot, problem.samples
        history = recursive_history(robot, samples, problem.h_cm, progress=progress)
        nothing = np.zeros((history.beta.shape[1], 0))
        last = BetaEstimate(history.beta[-1], history.covariance, nothing)
        since = history.t > (history.changes[-1].t if history.changes else -np.inf)
        goodness = Goodness(
            float(history.nis[since].sum()),
            float(history.dof[since].sum()),
            history.declared,
        )
        rms = rms_of_equations(problem)
        estimate = estimate_of_beta(problem, last, "recursion", rms, goodness)
        base = estimate.found.base
        learnt = base._replace(determined=base.determined & history.determined)
        return replace(
            estimate,
            found=estimate.found._replace(base=learnt),
            biases=biases_of_sensors(problem, history.biases),
            history=history,
        )
