"""Can a robot with the identified parameters exist? Its kinetic energy is positive."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.checks import Check
from orbident.estimation.found import Known
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.model.inertia import inertia
from orbident.model.rotor_momentum import rotor_deviations
from orbident.robot.description import Robot

CONFIGURATIONS = 32
"""The energy is tested at so many evenly spaced samples of the recording."""

CERTAIN = 3.0
"""Standard deviations below zero that are no chance."""

ROUNDING = 1e-9
"""A moment of inertia below zero by less than this part of the largest one is zero."""

STEP = 1e-6
"""The step of a parameter, in its deviations, for a derivative by difference."""


class _Least(NamedTuple):
    """The least moment of inertia of any motion of base and joints, kg m^2."""

    moment: float
    std: float | None
    """None where it is not negative."""


def positive_energy(problem: MomentumProblem, base: Known) -> Iterator[Check]:
    """Whether `[[D, D_q], [D_q^T, D_qq]]` (Eq. 6) is positive definite.

    Args:
        problem: the configurations that were recorded.
        base: the identified base parameters.
    """
    if not (base.determined.all() and np.isfinite(base.values).all()):
        return
    robot, name = problem.robot, "kinetic energy"
    least = _least(problem, robot, base.values, base.covariance)
    if least.std is None:
        yield Check(
            name, "trust", "the kinetic energy is positive", "", least.moment, 0.0
        )
        if problem.sets.rotors.any():
            yield from _links_alone(problem, base)
        return
    certain = least.moment < -CERTAIN * least.std
    yield Check(
        name,
        "do not trust" if certain else "with care",
        f"a motion of the joints would have negative energy (moment {least.moment:.2g} "
        f"+- {least.std:.2g} kg m^2), so no robot has such parameters",
        "check the signs of wheels, joints and gyro, --initial-momentum, and motors "
        "behind gears (rotors)"
        if certain
        else "record a longer or richer motion",
        least.moment,
        -CERTAIN * least.std,
    )


def _links_alone(problem: MomentumProblem, base: Known) -> Iterator[Check]:
    """Whether links can exist without the rotors that the robot file declares."""
    off = problem.sets.base.T @ rotor_deviations(problem.robot)
    alone = replace(problem.robot, rotors={})
    least = _least(problem, alone, base.values, base.covariance + off @ off.T)
    if least.std is not None and least.moment < -CERTAIN * least.std:
        yield Check(
            "rotors",
            "with care",
            "without the motors' rotors that are declared, links would have negative "
            f"energy (moment {least.moment:.2g} +- {least.std:.2g} kg m^2)",
            "correct rotors in the robot file: they are not as large",
            least.moment,
            -CERTAIN * least.std,
        )


def _least(
    problem: MomentumProblem,
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    covariance: Float[np.ndarray, "beta beta"],
) -> _Least:
    q = problem.samples.configurations(CONFIGURATIONS)
    moments, axes = np.linalg.eigh(_energy(problem, robot, beta, q))
    worst = int(moments[:, 0].argmin())
    least, v, at = moments[worst, 0], axes[worst, :, 0], q[worst : worst + 1]
    # A link without mass makes it zero.
    if least > -ROUNDING * moments.max():
        return _Least(float(least), None)
    deviations = np.sqrt(np.diag(covariance))
    slopes = [
        (v @ _energy(problem, robot, beta + STEP * std * one, at)[0] @ v - least)
        / (STEP * std)
        if std > 0
        else 0.0
        for one, std in zip(np.eye(deviations.size), deviations, strict=True)
    ]
    std = float(np.sqrt(np.maximum(slopes @ covariance @ slopes, 0.0)))
    return _Least(float(least), std)


def _energy(
    problem: MomentumProblem,
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    q: Float[np.ndarray, "n joints"],
) -> Float[np.ndarray, "n all all"]:
    """Matrices of the kinetic energy, in the axes in which momentum is conserved."""
    sets = problem.sets
    axes = list(sets.regressors.momentum_axes)
    at = inertia(replace(robot, theta=sets.theta(beta)), q)
    D, D_q = at.D[:, axes][:, :, axes], at.D_q[:, axes]
    return np.block([[D, D_q], [np.swapaxes(D_q, 1, 2), at.D_qq]])
