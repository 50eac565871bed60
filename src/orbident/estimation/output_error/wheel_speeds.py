"""Speeds of wheels as tachometers and the gyro show them together.

A speed that is used as it was read has its tachometer's noise, and so has what is
predicted of the base's rate: `J e` with `J = -D^-1 A_rw` (Eq. 3), `e` the speed that is
missing. The gyro's weights know that. Yet the derivatives by the parameters are of the
speeds, too: they take noise for motion that turned no base, and what acts may take all
the motion that is as slow as it is. The base is then found too large, without a larger
residual (errors in variables; Fuller 1987, section 1.1).

Of a residual `r` of the gyro, whose own noise is `s`, the most likely part of `e` is

    e = S J^T (J S J^T + s^2)^-1 r

with `S` the tachometers' variances. Where the speeds have that and the gyro shows `J e`
more, residuals stay as they are, and derivatives are of what moved (Dempster, Laird and
Rubin 1977). The parameters change `J`, and so that is done until they stay.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.noise_scaling import Fitted
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.sensors import Sensors
from orbident.model.core_robot import wheels_of
from orbident.preprocessing.rate_noise import rate_noise
from orbident.preprocessing.samples import Samples

GYRO = "gyro"


def has_read_speeds(samples: Samples, sensors: Sensors) -> bool:
    """Whether speeds are used as they were read, with noise, and a gyro is there."""
    return any(each.white for each in samples.speeds) and GYRO in sensors.by_name


def likely_speeds(
    problem: MomentumProblem, sensors: Sensors, own: Problem, found: Fitted
) -> tuple[Samples, Sensors]:
    """The samples with likely speeds, and a gyro that shows as much more.

    Args:
        problem: of a recording.
        sensors: what they showed.
        own: its equations, perhaps with likely speeds already.
        found: a fit to these.
    """
    robot, samples = problem.robot, problem.samples
    white = np.array([each.white for each in samples.speeds])
    t, gyro = own.t, sensors.by_name[GYRO]
    left = own.samples[GYRO] - np.column_stack(found.predicted(own, GYRO))
    r = np.where(np.isfinite(left) & (own.weights[GYRO] > 0), left, 0.0)
    J = _turned_by_speeds(problem, found.solution.state.beta, t)
    alone = gyro.std**2 - rate_noise(robot, samples.speeds) ** 2
    JS = J * white**2
    covariance = JS @ np.swapaxes(J, 1, 2)
    covariance += max(alone, gyro.least**2) * np.eye(3)
    weighed = np.linalg.solve(covariance, r[..., None])
    e = (np.swapaxes(JS, 1, 2) @ weighed)[..., 0]
    turned = (J @ e[..., None])[..., 0]
    speeds = tuple(
        x + np.interp(samples.t, t, more)
        for x, more in zip(samples.qd_rw, e.T, strict=True)
    )
    more = np.column_stack([np.interp(sensors.t, t, x) for x in turned.T])
    shown = {**sensors.by_name, GYRO: replace(gyro, values=gyro.values + more)}
    return replace(samples, qd_rw=speeds), replace(sensors, by_name=shown)


def _turned_by_speeds(
    problem: MomentumProblem,
    beta: Float[np.ndarray, " beta"],
    t: Float[np.ndarray, " rows"],
) -> Float[np.ndarray, "rows 3 wheels"]:
    """`J` at these times; zero in the axes about which momentum is not conserved."""
    samples, sets = problem.samples, problem.sets
    axes = [*sets.regressors.momentum_axes]
    q = np.reshape([np.interp(t, samples.t, x) for x in samples.q], (-1, t.size)).T
    pi, still = sets.pi(sets.theta(beta)), np.zeros_like(q)
    D = [
        sets.regressors(q, still, np.tile(w, (t.size, 1)))[0] @ pi
        for w in np.eye(3)[axes]
    ]
    A_rw = wheels_of(problem.robot).A_rw
    J = np.zeros((t.size, *A_rw.shape))
    J[:, axes] = -np.linalg.solve(np.stack(D, axis=-1), A_rw[axes])
    return J
