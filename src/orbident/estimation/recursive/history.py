"""A whole recording through the filter: how its estimate came about, what changed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.estimation.recursive.changes import Change, Detector
from orbident.estimation.recursive.extended import Extended
from orbident.estimation.recursive.linear_sets import linear_sets_at
from orbident.estimation.recursive.noise import Noise, noise_of
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    Prior,
    cad_covariance,
    cad_prior,
)
from orbident.estimation.recursive.sample import stream
from orbident.estimation.recursive.state import State
from orbident.precision import in_float64
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.signals.base_motion import SMOOTHED
from orbident.signals.histories import DERIVED
from orbident.signals.samples import Samples
from orbident.signals.smoothing import smooth

ENDS = 0.5
"""s: so near to the ends of a recording a smoothed rate is ten times as wrong."""

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
    biases: dict[str, Float[np.ndarray, " k"]]
    """Of the sensors, at the end."""


@in_float64
def recursive_history(
    robot: Robot,
    samples: Samples,
    prior: Prior | None = None,
    noise: Noise | None = None,
    at_rest: bool = False,
    false_alarms: float = 1e-4,
    progress: Callable[[float], object] = lambda _: None,
) -> History:
    """Estimate sample by sample, watch for changes, and open up after one.

    Args:
        robot: its nominal inertia is where the filter starts.
        samples: of a recording.
        prior: of `beta`; CAD values with 30 % uncertainty where it is None.
        noise: of the sensors; as the robot file and the samples say where it is None.
        at_rest: all was at rest before the wheels spun up: the momentum is zero.
        false_alarms: probability of one in this recording if nothing changes.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: no sample is complete.
    """
    sets = minimal_sets(robot)
    rate, scatter = smoothed_rate(samples)
    noise = noise_of(robot, sets, samples, scatter) if noise is None else noise
    prior = cad_prior(robot, sets) if prior is None else prior
    opening = cad_covariance(robot, sets, UNCERTAINTY)
    first, last = _trusted(samples)
    every = [s for s in stream(samples, rate) if s.complete and first <= s.t <= last]
    if not every:
        raise InputError(
            f"{samples.source}: no complete sample; record joints, wheels, gyro and "
            "attitude together"
        )
    kalman = Extended.of(robot, sets, noise)
    state = kalman.start(prior, every[0], at_rest)
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
        biases=kalman.biases(state),
    )


def _trusted(samples: Samples) -> tuple[float, float]:
    """From when to when rates are as good as they are said to be, s."""
    derived = DERIVED in samples.origins["joint_rates"]
    margin = ENDS if derived and np.ptp(samples.t) > 4 * ENDS else 0.0
    return float(samples.t[0]) + margin, float(samples.t[-1]) - margin


def _scaled(robot: Robot, state: State) -> bool:
    """Whether the momentum equation has a known term that is more than noise.

    Noise counts as that of the nominal robot: without a scale the estimate shrinks to
    nothing, and beside so small a robot's noise anything would be known.
    """
    pis = len(minimal_sets(robot).pi_of_beta)
    known = np.linalg.norm(state.parts.R_z[:pis, -1]) * state.beta[0] / robot.mass
    return bool(robot.wheels and known**2 > KNOWN * pis)


def smoothed_rate(samples: Samples) -> tuple[Float[np.ndarray, "samples 3"], float]:
    """The base rate as smooth as joint rates are, and the gyro's scatter, rad/s."""
    w = np.column_stack(samples.w)
    if samples.origins["base_rate"] == SMOOTHED:
        return w, 0.0
    smoothed = smooth(samples.t, w, name=f"{samples.source}: gyro")
    return smoothed.x, float(np.nan_to_num(smoothed.noise_std).max())
