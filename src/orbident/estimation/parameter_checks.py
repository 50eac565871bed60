"""Can a robot have the parameters that were found? Checks of the numbers themselves.

The total mass is there by several routes: which count, and whether they agree. The
kinetic energy of a robot that exists is positive.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.base_parameters import Known
from orbident.estimation.checks import Check, Level
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.quantities import Quantity
from orbident.estimation.residual_checks import CAUSES
from orbident.estimation.unknowns import DriveFit
from orbident.model.core_robot import (
    rotor_deviations,
    spinning_rotors,
    with_armatures,
)
from orbident.model.kinematics import inertia
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot

BURN = "Eq. 40"
"""The mass by a thruster burn, among others."""

SURE = 0.1
"""A route whose deviation is beyond this part of the mass gives no mass."""

DISAGREE = 5.0
"""Combined deviations by which two masses differ that cannot both be right,"""

MATTERS = 0.03
"""and this part of the mass: by less, the other route is in doubt, not the result."""

WHITE_ONLY = (
    "use the first: the deviations of Eq. 32 count white noise only, so they are too "
    "narrow where encoders or a drift add to it"
)

IN_WHEELS = "with more momentum in the wheels"

OF_SIGNS = "check the signs of wheels' speeds and axes, and --initial-momentum"

TWICE = 2.0
"""Times: a recording that tells too little is to be so many times as long at least."""

MOST_TIMES = 20.0
"""Times: of a motion that would have to be longer than that nothing is known."""

SPREAD = 0.5
"""Forms of Eq. 32 that differ by more than this do not measure one mass."""

VAGUE = 0.3
"""A mass counts as determined if its deviation is below this part of it."""


def is_a_mass(value: float, std: float, M: Quantity) -> bool:
    """Whether a route to the mass gives one: its deviation is a tenth of it at most.

    Args:
        value: of this route, kg.
        std: its deviation.
        M: the method's own mass, which says what a tenth is where it is determined.
    """
    whole = M.value if np.isfinite(M.value) else value
    return bool(std <= SURE * abs(whole))


def sigmas_apart(one: Quantity, other: Quantity) -> float:
    """The difference over its deviation, as if the two were independent."""
    std = float(np.hypot(one.std, other.std))
    return (one.value - other.value) / std if std > 0 else float("nan")


def agreement_of_routes(masses: dict[str, Quantity]) -> Iterator[Check]:
    """Whether the last route's mass is one of the others'.

    The statistic is how far beyond both limits, of sigmas and of percent, the worst is.
    Beyond the limit of sigmas alone the result stands, and the remedy says which mass
    to use.
    """
    *others, (route, M) = masses.items()
    if not others:
        return
    apart = {name: abs(sigmas_apart(value, M)) for name, value in others}
    part = {name: abs(value.value / M.value - 1) for name, value in others}
    # Both are to be broken.
    over = {name: min(apart[name] / DISAGREE, part[name] / MATTERS) for name in apart}
    far = [name for name in over if over[name] > 1]
    no_chance = far or [name for name in apart if apart[name] > DISAGREE]
    words = [
        f"{value.value:.6g} +- {value.std:.2g} kg by {name} ({apart[name]:.2g} sigmas "
        f"apart, {100 * part[name]:.2g} %)"
        for name, value in others
        if name in no_chance or not no_chance
    ]
    reason = (
        f"mass: {M.value:.6g} +- {M.std:.2g} kg by {route}, "
        f"{'but' if no_chance else 'and'} {', '.join(words)}"
    )
    level: Level = "with care" if far else "trust"
    remedy = ""
    if far:
        remedy = (
            "check the burn's force" if BURN in masses else f"weigh the robot ({BURN})"
        )
        remedy += ", or record a richer motion"
    elif no_chance:
        remedy = "check the burn's force" if BURN in no_chance else WHITE_ONLY
    yield Check("routes to the mass", level, reason, remedy, max(over.values()), 1.0)


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


def positive_energy(
    problem: MomentumProblem, base: Known, drives: Mapping[str, DriveFit]
) -> Iterator[Check]:
    """Whether `[[D, D_q], [D_q^T, D_qq]]` (Eq. 6) is positive definite.

    Args:
        problem: the configurations that were recorded.
        base: the identified base parameters.
        drives: rotors that torques showed.
    """
    if not (base.determined.all() and np.isfinite(base.values).all()):
        return
    armatures = {name: fit[:2] for name, fit in drives.items()}
    robot, name = with_armatures(problem.robot, armatures), "kinetic energy"
    sets = minimal_sets(robot)
    least = _least(problem, sets, robot, base.values, base.covariance)
    if least.std is None:
        yield Check(
            name, "trust", "the kinetic energy is positive", "", least.moment, 0.0
        )
        if problem.sets.rotors.any():
            yield from _links_alone(problem, base)
        return
    certain = least.moment < -CERTAIN * least.std
    found = f"{least.moment:.2g} +- {least.std:.2g} kg m^2"
    yield Check(
        name,
        "do not trust" if certain else "with care",
        "the mass matrix is not positive definite (least moment of a motion of the "
        f"joints: {found}): no robot has such parameters"
        if certain
        else "the recording leaves open how hard some motion of the joints is (its "
        f"moment: {found}), so H+ is of the nearest bodies that can exist",
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
    # Of parameters less the rotors that are declared.
    covariance = base.covariance + off @ off.T
    least = _least(problem, problem.sets, alone, base.values, covariance)
    if least.std is not None and least.moment < -CERTAIN * least.std:
        yield Check(
            "rotors",
            "with care",
            "without the motors' rotors that are declared, links would have negative "
            f"energy (moment {least.moment:.2g} +- {least.std:.2g} kg m^2)",
            "correct rotors in the robot file: they are not as large, or turn the "
            "other way (a gear below zero)",
            least.moment,
            -CERTAIN * least.std,
        )


def _least(
    problem: MomentumProblem,
    sets: MinimalSets,
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    covariance: Float[np.ndarray, "beta beta"],
) -> _Least:
    q = problem.samples.configurations(CONFIGURATIONS)
    moments, axes = np.linalg.eigh(_energy(sets, robot, beta, q))
    worst = int(moments[:, 0].argmin())
    least, v, at = moments[worst, 0], axes[worst, :, 0], q[worst : worst + 1]
    # A link without mass makes it zero.
    if least > -ROUNDING * moments.max():
        return _Least(float(least), None)
    deviations = np.sqrt(np.diag(covariance))
    slopes = [
        (v @ _energy(sets, robot, beta + STEP * std * one, at)[0] @ v - least)
        / (STEP * std)
        if std > 0
        else 0.0
        for one, std in zip(np.eye(deviations.size), deviations, strict=True)
    ]
    std = float(np.sqrt(np.maximum(slopes @ covariance @ slopes, 0.0)))
    return _Least(float(least), std)


def _energy(
    sets: MinimalSets,
    robot: Robot,
    beta: Float[np.ndarray, " beta"],
    q: Float[np.ndarray, "n joints"],
) -> Float[np.ndarray, "n all all"]:
    """Matrices of the kinetic energy, in the axes in which momentum is conserved."""
    axes = sets.regressors.momentum_axes
    at = inertia(replace(robot, theta=sets.theta(beta)), q).energy(axes)
    # A motor of a flexible joint lacks what its rotor's energy has beside momentum.
    motors = [len(axes) + k for k in spinning_rotors(robot)]
    return np.delete(np.delete(at, motors, axis=1), motors, axis=2)


def possible_numbers(estimate: Estimate, tracked: bool) -> Iterator[Check]:
    """Whether what is determined has a value, and the mass is one.

    A recursion whose samples tell no scale has none.

    Args:
        estimate: of a recording.
        tracked: whether it shows a mass.
    """
    found, M = estimate.parameters, estimate.mass
    numbers = [np.array([M.value, M.std] if tracked else [])] + [
        x[known.determined]
        for known in (found.pi, found.phi, found.base)
        for x in (known.values, np.diag(known.covariance))
    ]
    finite = np.isfinite(np.concatenate(numbers)).all()
    reason = "what was found is no number: too few samples count, or they overflow"
    if finite:
        reason = f"mass: found {M.value:.4g} kg, which no robot has"
    if not finite or M.value <= 0:
        yield Check("possible numbers", "do not trust", reason, CAUSES)


def mass_checks(
    problem: MomentumProblem, estimate: Estimate, shown: Estimate
) -> Iterator[Check]:
    """Whether the mass is determined, and its forms of Eq. 32 agree."""
    M, std = estimate.mass.value, estimate.mass.std
    level: Level
    more = long_enough(problem, M, std)
    yield from _forms(problem, shown)
    if estimate is not shown:
        # Its deviations hold how far it is from what the sensors show.
        level, remedy = "with care", "identify by maximum-likelihood"
    else:
        level = "do not trust"
        remedy = f"record a richer or longer motion{more}, {IN_WHEELS}"
    history = estimate.history
    by_sensors = shown.mass.value
    if not M > 0 or by_sensors < 0:
        least = by_sensors if M > 0 else M
        nothing, sure = np.isnan(least), shown.mass.std < -VAGUE * by_sensors
        found = "nothing tells it" if nothing else f"found {least:.4g} kg, below zero"
        longer = f"record a longer motion{more}, {IN_WHEELS}"
        remedy = OF_SIGNS if sure else longer
        yield Check("mass", "do not trust", f"mass: {found}", remedy)
    elif history is not None and not history.determined[0]:
        yield Check(
            "mass",
            level,
            "mass: the recursion has learnt hardly more of it than the nominal value "
            "that it starts from",
            remedy,
        )
    elif not std < VAGUE * M:
        yield Check(
            "mass",
            level,
            f"mass: found {M:.4g} kg with a standard deviation of {std:.2g} kg",
            remedy,
            std / M,
            VAGUE,
        )


def size_of_pi(estimate: Estimate) -> Iterator[Check]:
    """Whether momentum alone says how large `pi` is: nothing else does then."""
    pi = estimate.parameters.pi
    values, C = pi.values[pi.determined], pi.covariance[pi.determined][:, pi.determined]
    size = float(np.linalg.norm(values))
    std = float(np.sqrt(max(values @ C @ values, 0.0)))
    # Where nothing of it is determined, that is said already.
    if size and not std < VAGUE * size**2:
        reason = f"pi: how large all of it is, is known to {std / size**2:.0%} only"
        remedy = f"record a richer or longer motion, {IN_WHEELS}"
        yield Check("size of pi", "do not trust", reason, remedy, std / size**2, VAGUE)


def long_enough(problem: MomentumProblem, M: float, std: float) -> str:
    """How long a motion like it has to be: deviations fall with the root of time."""
    vague = std / (VAGUE * abs(M)) if M else np.inf
    times = max(vague**2, TWICE)
    if not times < MOST_TIMES:
        return ""
    return f" (some {times * np.ptp(problem.samples.t):.2g} s like it)"


def _forms(problem: MomentumProblem, estimate: Estimate) -> Iterator[Check]:
    """Whether the forms of Eq. 32 give one mass.

    They may differ because linear fits with white noise are poor: where residuals over
    noise say whether the equations hold, they do not count.
    """
    if not problem.linear or estimate.goodness is not None:
        return
    mass = problem.linear_mass
    if mass.value > 0 and mass.spread < SPREAD:
        return
    if not len(mass.forms):
        reason = "mass: no form of Eq. 32 is determined"
        remedy = "weigh the robot with a thruster burn (Eq. 40)"
        yield Check("Eq. 32", "do not trust", reason, remedy)
        return
    yield Check(
        "Eq. 32",
        "do not trust",
        f"mass: the forms of Eq. 32 give {mass.values.min():.4g} to "
        f"{mass.values.max():.4g} kg",
        CAUSES,
        mass.spread,
        SPREAD,
    )
