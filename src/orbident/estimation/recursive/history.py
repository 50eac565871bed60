"""A whole recording through the filter: how its estimate came about, what changed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.estimation.recursive.changes import Change, Detector
from orbident.estimation.recursive.extended import Extended
from orbident.estimation.recursive.given import given_of
from orbident.estimation.recursive.linear_sets import linear_sets_at
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    cad_covariance,
    cad_prior,
)
from orbident.estimation.recursive.state import State
from orbident.precision import in_float64
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.signals.samples import Samples

LEARNT = 0.5
"""Below this part of what it was beforehand, an uncertainty comes from the samples."""

KNOWN = 100.0
"""What the known term of the momentum equation is at least, squared, over its noise."""


class History(NamedTuple):
    """One row a sample that counted."""

    t: Float[np.ndarray, " n"]
    beta: Float[np.ndarray, "n beta"]
    std: Float[np.ndarray, "n beta"]
    pi: Float[np.ndarray, "n pi"]
    phi: Float[np.ndarray, "n phi"]
    M: Float[np.ndarray, " n"]
    nis: Float[np.ndarray, " n"]
    """Normalised innovation squared: chi-square with `dof` degrees of freedom."""
    dof: Float[np.ndarray, " n"]
    statistic: Float[np.ndarray, " n"]
    """Of the detector, over its threshold."""
    changes: tuple[Change, ...]
    covariance: Float[np.ndarray, "beta beta"]
    """Of the last `beta`."""
    determined: Bool[np.ndarray, " beta"]
    """Whether the samples, and not the prior, tell the last `beta`: without a wheel
    nothing tells the scale."""
    scale: bool
    """Whether the wheels' momentum told the scale of `pi`. Where it did not, `beta`,
    `pi` and `M` are NaN, and no change can be told."""
    consistent: bool
    """Whether the samples since the last change agree with each other, within the noise
    that the sensors are declared with."""
    biases: dict[str, dict[str, float]]
    """Of the sensors, at the end: `value` and `std`."""


@in_float64
def recursive_history(
    robot: Robot,
    samples: Samples,
    h_cm: Float[np.ndarray, "3"] | None = None,
    false_alarms: float = 1e-4,
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
    sets = minimal_sets(robot)
    every, noise = given_of(robot, sets, samples)
    prior = cad_prior(robot, sets)
    opening = cad_covariance(robot, sets, UNCERTAINTY)
    kalman = Extended.of(robot, sets, noise)
    state = kalman.start(prior, every[0], h_cm)
    detector = Detector(kalman.rows, false_alarms=false_alarms, samples=len(every))
    watch, rows, changes, scale = detector.start(), [], [], False
    for k, sample in enumerate(every):
        progress(k / len(every))
        state, info = kalman.step(state, sample)
        watch, statistic, change = detector.step(watch, sample.t, info.white)
        if change is not None:
            changes.append(change)
            scale |= _scaled(robot, state)
            state, watch = kalman.opened(state, opening), detector.start()
        std = np.sqrt(np.diag(state.covariance))
        rows.append((sample.t, state.beta, std, info.nis, info.dof, statistic))
    t, beta, std, nis, dof, statistic = (np.array(c) for c in zip(*rows, strict=True))
    inverse = np.linalg.inv(prior.root)
    beforehand = np.linalg.norm(inverse, axis=1)
    y = np.array([linear_sets_at(kalman.sets, row)[0] for row in beta])
    pis = len(sets.pi_of_beta)
    scale |= _scaled(robot, state)
    unknown = 0.0 if scale else np.nan
    since = t > (changes[-1].t if changes else -np.inf)
    left = float(nis[since].sum() / max(dof[since].sum(), 1.0))
    return History(
        t=t,
        beta=beta + unknown,
        std=std + unknown,
        pi=y[:, :pis] + unknown,
        phi=y[:, pis:],
        M=beta[:, 0] + unknown,
        nis=nis,
        dof=dof.astype(float),
        statistic=statistic,
        changes=tuple(changes) if scale else (),
        covariance=state.covariance,
        determined=(std[-1] < LEARNT * beforehand) & scale,
        scale=scale,
        consistent=noise.explains(left),
        biases=kalman.biases(state.parts.top, state.beta, state.covariance),
    )


def _scaled(robot: Robot, state: State) -> bool:
    """Whether the momentum equation has a known term that is more than noise.

    Noise counts as that of the nominal robot: without a scale the estimate shrinks to
    nothing, and beside so small a robot's noise anything would be known.
    """
    pis = len(minimal_sets(robot).pi_of_beta)
    known = np.linalg.norm(state.parts.R_z[:pis, -1]) * state.beta[0] / robot.mass
    return bool(robot.wheels and known**2 > KNOWN * pis)
