"""A whole recording through the filter: how its estimate came about, what changed.

While nothing changes, whitened innovations are independent with zero mean. A capture,
a release or a loss gives them a mean, unknown and from an unknown sample on; twice the
logarithm of the likelihood ratio is then (Willsky and Jones 1976; Basseville and
Nikiforov 1993, section 4.4)

    g = max over j of |white_j + ... + white_k|^2 / (k - j + 1)

and each of its terms is chi-square with as many degrees of freedom as there are rows
(the core's `change_detection.hpp`). The probability that any of them exceeds a
threshold in a whole run is at most the sum over all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import chdtrc, chdtri

from orbident import _core
from orbident.estimation.base_parameters import BetaEstimate
from orbident.estimation.estimate import (
    Change,
    Estimate,
    Goodness,
    History,
    Progress,
    biases_of_sensors,
    estimate_of_beta,
    rms_of_equations,
)
from orbident.estimation.levels import LEVELS
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursive.driven_joints import Torques, torques_of
from orbident.estimation.recursive.filter import (
    UNCERTAINTY,
    Extended,
    State,
    cad_covariance,
    cad_prior,
)
from orbident.estimation.recursive.filter_input import FilterInput, filter_input_of
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

COLOUR = 2.0
"""Smoothed joint rates keep an encoder's error for half a second: sums of innovations
vary by up to so much more than white ones."""

FEW = 3
"""Changes that are named one by one: a recording hardly has more."""

LEAST = 1e-15
"""A probability that is less is rounding."""


@dataclass(frozen=True)
class Detector:
    """The test, and how often it may be wrong."""

    rows: int
    """Size of an innovation."""
    window: int = 20
    """Samples that the onset may lie back."""
    false_alarms: float = LEVELS["change"]
    """Probability of one in a run of so many samples without a change, at most."""
    samples: int = 1600

    @cached_property
    def threshold(self) -> float:
        """Threshold of `g`."""
        each = self.false_alarms / (self.samples * self.window)
        return COLOUR * float(chdtri(self.rows, each))

    def start(self) -> _core.Watch:
        """Nothing seen."""
        return _core.Watch(self.rows, self.window)

    def step(
        self, watch: _core.Watch, t: float, white: Float[np.ndarray, " e"]
    ) -> tuple[_core.Watch, float, Change | None]:
        """Take one innovation in.

        Args:
            watch: what was seen before; it is not changed.
            t: of the sample, s.
            white: its whitened innovation.

        Returns:
            What is remembered, `g` over its threshold, and the change if there is one.
        """
        after, g, onset = watch.step(t, np.ascontiguousarray(white, dtype=float))
        change = self.change(t, onset, g) if g > self.threshold else None
        return after, g / self.threshold, change

    def change(self, t: float, onset: float, g: float) -> Change:
        """The change that a statistic above the threshold tells."""
        tests = self.samples * self.window
        alarm = min(1.0, tests * float(chdtrc(self.rows, g / COLOUR)))
        return Change(t, onset, g / self.threshold, 1.0 - alarm)


def changes_in_words(changes: Sequence[Change]) -> tuple[str, ...]:
    """The first ones, a sentence each, and how many more there are."""
    first = tuple(
        f"the robot changed at t = {change.onset:.4g} s (found at {change.t:.4g} s; by "
        "chance with a probability of at most "
        f"{max(1 - change.confidence, LEAST):.1g}): the estimates are those after that"
        for change in changes[:FEW]
    )
    more = changes[FEW:]
    if not more:
        return first
    return (
        *first,
        f"the robot seems to have changed {len(more)} more times, last at t = "
        f"{more[-1].onset:.4g} s: check the robot file, the signs and units of the "
        "recording, and --initial-momentum",
    )


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
    changes: Sequence[Change] | None = None,
    torques: Torques | None = None,
) -> History:
    """Estimate sample by sample, watch for changes, and open up after one.

    Args:
        robot: the filter starts from its nominal inertia, with 30 % uncertainty.
        samples: of a recording.
        h_cm: the momentum where it is known, inertial axes, N m s.
        false_alarms: probability of one in this recording if nothing changes.
        progress: is called with the fraction of the samples that is done.
        changes: where they are known, and none is watched for.
        torques: of joints, where they are used.

    Raises:
        InputError: no sample is complete.
    """
    given = filter_input_of(robot, samples, torques)
    prior, t = cad_prior(robot), given.t
    kalman = Extended.of(robot, given.noise)
    detector = Detector(kalman.rows, false_alarms=false_alarms, samples=t.size)
    at = filter_history(robot, kalman, detector, given, h_cm, progress, changes)
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
    given: FilterInput,
    h_cm: Float[np.ndarray, "3"] | None,
    progress: Callable[[float], object] = lambda _: None,
    known: Sequence[Change] | None = None,
) -> FilterHistory:
    """Take all samples in, one by one, and open up after every change.

    Args:
        robot: whose nominal inertia is the prior, with 30 % uncertainty.
        kalman: its filter.
        detector: of changes.
        given: the samples.
        h_cm: the momentum where it is known, inertial axes, N m s.
        progress: is called with the fraction of the samples that is done.
        known: the changes, where none is watched for.
    """
    left = [] if known is None else [*known]
    threshold = detector.threshold if known is None else np.inf
    t, every, opening = given.t, given.samples, cad_covariance(robot, UNCERTAINTY)
    state = kalman.begun(cad_prior(robot), every[0], h_cm)
    watch, parts, changes, scale, done = detector.start(), [], [], False, 0
    while done < t.size:
        progress(done / t.size)
        next_one = int(np.searchsorted(t, left[0].t, "right")) if left else t.size
        part = slice(done, min(done + PART, max(next_one, done + 1)))
        after, watch, count, onset, beta, std, tests = kalman.core.run(
            state.core, watch, threshold, t[part], every[part]
        )
        state, done = State(after), done + count
        parts.append((beta[:count], std[:count], tests[:count]))
        changed = None
        if onset is not None:
            g = float(tests[count - 1, 2])
            changed = detector.change(float(t[done - 1]), onset, g)
        elif left and done >= next_one:
            changed = left.pop(0)
        if changed is not None:
            changes.append(changed)
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
    changes: tuple[Change, ...] | None = None
    """Where they are known; then none is watched for."""

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Take the samples one by one.

        Raises:
            InputError: no sample is complete.
        """
        robot, samples = problem.robot, problem.samples
        history = recursive_history(
            robot,
            samples,
            problem.h_cm,
            progress=progress,
            changes=self.changes,
            torques=torques_of(robot, problem.recording, samples, problem.late),
        )
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
        base = estimate.parameters.base
        learnt = base._replace(determined=base.determined & history.determined)
        return replace(
            estimate,
            parameters=estimate.parameters._replace(base=learnt),
            biases=biases_of_sensors(problem, history.biases),
            history=history,
        )
