"""Can a robot with the identified parameters exist? Its kinetic energy is positive."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from orbident.estimation.checks import Check
from orbident.estimation.found import Known
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.model.inertia import inertia

CONFIGURATIONS = 32
"""The energy is tested at so many evenly spaced samples of the recording."""

CERTAIN = 3.0
"""Standard deviations below zero that are no chance."""

ROUNDING = 1e-9
"""A moment of inertia below zero by less than this part of the largest one is zero."""

STEP = 1e-6
"""The step of a parameter, in its deviations, for a derivative by difference."""


def positive_energy(problem: MomentumProblem, base: Known) -> Iterator[Check]:
    """Whether `[[D, D_q], [D_q^T, D_qq]]` (Eq. 6) is positive definite.

    Args:
        problem: the configurations that were recorded.
        base: the identified base parameters.
    """
    if not (base.determined.all() and np.isfinite(base.values).all()):
        return
    q = problem.samples.configurations(CONFIGURATIONS)
    moments, axes = np.linalg.eigh(_energy(problem, base.values, q))
    worst = int(moments[:, 0].argmin())
    least, v, at = moments[worst, 0], axes[worst, :, 0], q[worst : worst + 1]
    name = "kinetic energy"
    # A link without mass makes it zero.
    if least > -ROUNDING * moments.max():
        yield Check(name, "trust", "the kinetic energy is positive", "", least, 0.0)
        return
    deviations = np.sqrt(np.diag(base.covariance))
    slopes = [
        (v @ _energy(problem, base.values + STEP * std * one, at)[0] @ v - least)
        / (STEP * std)
        if std > 0
        else 0.0
        for one, std in zip(np.eye(deviations.size), deviations, strict=True)
    ]
    std = float(np.sqrt(np.maximum(slopes @ base.covariance @ slopes, 0.0)))
    certain = least < -CERTAIN * std
    yield Check(
        name,
        "do not trust" if certain else "with care",
        f"a motion of the joints would have negative energy (moment {least:.2g} +- "
        f"{std:.2g} kg m^2), so no robot has such parameters",
        "check the signs of wheels, joints and gyro, --initial-momentum, and motors "
        "behind gears (rotors)"
        if certain
        else "record a longer or richer motion",
        float(least),
        -CERTAIN * std,
    )


def _energy(
    problem: MomentumProblem,
    beta: Float[np.ndarray, " beta"],
    q: Float[np.ndarray, "n joints"],
) -> Float[np.ndarray, "n all all"]:
    """Matrices of the kinetic energy, in the axes in which momentum is conserved."""
    robot, sets = problem.robot, problem.sets
    axes = list(sets.regressors.momentum_axes)
    at = inertia(replace(robot, theta=sets.theta(beta)), q)
    D, D_q = at.D[:, axes][:, :, axes], at.D_q[:, axes]
    return np.block([[D, D_q], [np.swapaxes(D_q, 1, 2), at.D_qq]])
