"""What is known beforehand of the unknowns that all segments have in common.

And what a recording says of them to another one (`solution.py`).
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import AGENTS, WALKS
from orbident.errors import InputError
from orbident.estimation.base_parameters import hidden_of, prior_std
from orbident.estimation.linear_fits import Fits, InitialMomentum, known_momentum
from orbident.estimation.output_error.acting import LONGEST
from orbident.estimation.output_error.joint_laws import HELD
from orbident.estimation.output_error.noise_as_motion import NoiseAsMotion
from orbident.estimation.output_error.problem import (
    NOTHING,
    Problem,
    common_factor,
)
from orbident.estimation.solution import (
    OUTSIDE,
    Outside,
    Prior,
    Shared,
    Solution,
)
from orbident.estimation.triangular import triangular_factor
from orbident.estimation.unknowns import Unknown
from orbident.model.core_robot import rotors_of, spinning_rotors
from orbident.model.kinematics import carried_inertia, first_moments, poses
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

UNKNOWN = 1e3
"""Std beforehand: m/s, m, and times a momentum (or the wheels' at 1 rad/s)."""

KNOWN = 1e-9
"""Std of a known momentum, over the same."""

HELD_WITHIN = 1e-8
"""Std of what nothing shows, over that which it has else beforehand."""

ONE_MAKE = {"inertia": 0.01, "frequency": 0.01, "damping": 0.1}
"""Std of how far two of one make are apart, relative: what a workshop leaves, and less
than the 10 % within which deviations of first order do not hold."""


def first_momentum(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    fits: Fits,
    initial_momentum: InitialMomentum,
) -> Outside:
    """As the linear fit has it, or as it is known."""
    axes = np.array(sets.regressors.momentum_axes)
    known = known_momentum(robot, sets, samples, initial_momentum)
    h_cm = np.zeros(3)
    if known is None:
        h_cm[axes] = fits.pi.nuisances
    else:
        h_cm[axes] = known.h[axes] + known.Y_in @ fits.pi.values
    return NOTHING._replace(h_cm=h_cm)


def prior_of(
    robot: Robot,
    sets: MinimalSets,
    calibrations: Sequence[Unknown],
    outside: Outside,
    rest: Float[np.ndarray, "3"] | None,
) -> Prior:
    """What is known of the unknowns of all segments: `beta` is about nominal.

    Args:
        robot: with its wheels.
        sets: its minimal sets.
        calibrations: the errors that are unknown, which are about zero.
        outside: a first momentum.
        rest: deviations of the momentum where it is known, N m s; else None.
    """
    spin = sum(wheel.inertia for wheel in robot.wheels)
    # Without wheels: what turns once a second and is a metre large.
    h_std = max(float(np.linalg.norm(outside.h_cm)), spin) or robot.mass
    if rest is None:
        rest = np.full(3, UNKNOWN * h_std)
    # Nothing shows a momentum that would tilt a table's robot; tilts would move it.
    rest = np.where(np.isin(np.arange(3), sets.regressors.momentum_axes), rest, 0.0)
    # What is exact has some width, so that equations stay solvable.
    std = np.append(np.maximum(rest, KNOWN * h_std), np.full(6, UNKNOWN))
    return Prior(
        values=np.concatenate(
            [*outside, sets.beta(robot.theta), np.zeros(len(calibrations))]
        ),
        std=np.concatenate(
            [std, prior_std(robot, sets), [each.std for each in calibrations]]
        ),
        measured=measured_rows(robot, sets),
        carried=carried_rows(robot, sets, [each.name for each in calibrations]),
    )


def carried_rows(
    robot: Robot, sets: MinimalSets, errors: Sequence[str]
) -> Float[np.ndarray, "rows columns"]:
    """What is known of what passive joints carry, of two of one make, and of rotors.

    Whitened equations over `[outside | beta | errors]`. Relative to the nominal ones,
    inertias are one, and those of one make are alike, as their frequencies are.
    """
    beta, rows, own = sets.beta(robot.theta), [], {}
    for name, passive in robot.passive.items():
        by = carried_inertia(robot, robot.joint_names.index(name))
        by = by / (by @ robot.theta.ravel()) @ sets.base.theta_of
        none, nothing = np.zeros(OUTSIDE), np.zeros(OUTSIDE + beta.size)
        own[name] = {
            "inertia": np.concatenate([none, by, np.zeros(len(errors)), [by @ beta]])
        } | {
            what: np.concatenate(
                [nothing, [each == f"joint.{name}.{what}" for each in errors], [0.0]]
            )
            for what in ("frequency", "damping")
        }
        rows.append(own[name]["inertia"] / max(passive.inertia, HELD))
    momenta, _, tolerances = rotors_of(robot)
    for k, place in spinning_rotors(robot).items():
        if momenta[k]:
            by = sets.base.theta_of[place] / momenta[k]
            row = [np.zeros(OUTSIDE), by, np.zeros(len(errors)), [1.0]]
            rows.append(np.concatenate(row) / max(tolerances[k], HELD))
    rows += [
        (own[name][what] - own[passive.like][what]) / std
        for name, passive in robot.passive.items()
        for what, std in ONE_MAKE.items()
        if passive.like
    ]
    return np.reshape(rows, (len(rows), OUTSIDE + beta.size + len(errors) + 1))


def measured_rows(
    robot: Robot, sets: MinimalSets
) -> Float[np.ndarray, "measured columns"]:
    """Masses and CM that were measured: whitened equations over `[outside | beta]`.

    A CM `c`, from S, with all joints at zero: `moments beta - M c = 0`, over the
    deviation of `c` times the nominal mass.
    """
    theta_of, known = sets.base.theta_of, robot.known
    moments = first_moments(poses(robot, np.zeros((1, len(robot.joints)))))[0]
    rows = np.zeros((0, OUTSIDE + theta_of.shape[1] + 1))
    whole = np.eye(1, theta_of.shape[1])[0]
    weighed = [(whole, known.mass)] if known.mass else []
    for name, mass in known.bodies.items():
        by_beta = sets.of_mass(robot.bodies.index(name))
        # What no motion shows changes no base parameter.
        weighed += [] if by_beta is None else [(by_beta, mass)]
    for by_beta, (value, std) in weighed:
        row = np.concatenate([np.zeros(OUTSIDE), by_beta, [value]])
        rows = np.vstack([rows, row / std])
    for axis, (value, std) in known.com.items():
        k = "xyz".index(axis)
        by = moments[k] @ theta_of - (value - robot.feature_point[k]) * whole
        row = np.concatenate([np.zeros(OUTSIDE), by, [0.0]])
        rows = np.vstack([rows, row / (std * robot.mass)])
    return rows


def with_others(prior: Prior, others: Shared, calibrations: Sequence[Unknown]) -> Prior:
    """Add what other recordings of the robot say of `beta` and its instruments."""
    rows = others.over(calibrations)
    return prior._replace(others=np.hstack([np.zeros((len(rows), OUTSIDE)), rows]))


def with_hidden_held(prior: Prior, robot: Robot, sets: MinimalSets) -> Prior:
    """The prior of a recording without positions, which cannot tell some robots apart.

    Momentum alone shows `pi`, and many robots have the same. Of these the one nearest
    to nominal is taken: what is predicted of the momentum does not depend on it.

    Args:
        prior: of all unknowns.
        robot: with its nominal inertia.
        sets: its minimal sets.
    """
    beta, scale = sets.beta(robot.theta), prior_std(robot, sets)
    of_pi, _ = sets.derivatives(beta)
    of_beta = slice(OUTSIDE, OUTSIDE + beta.size)
    known = (rows[:, of_beta] for rows in (prior.others, prior.measured) if len(rows))
    hidden = hidden_of(np.vstack([of_pi, *known]), scale)
    rows = (hidden / scale[:, None] ** 2).T / HELD_WITHIN
    none = np.zeros((len(rows), OUTSIDE))
    return prior._replace(held=np.column_stack([none, rows, rows @ beta]))


def shared_of(problem: Problem, solution: Solution) -> Shared:
    """What a recording says of what it shares, its own unknowns eliminated.

    Args:
        problem: a recording's equations.
        solution: of these.
    """
    state, prior, errors = solution.state, solution.prior, problem.declared
    common = common_factor(problem, solution.weights, state)
    first = OUTSIDE + state.beta.size + len(errors)
    shared = np.arange(OUTSIDE, first)
    own = [*range(OUTSIDE), *range(first, state.common.size)]
    # What is known of the shared ones beforehand is known once, not in each recording.
    std = prior.std.copy()
    std[shared] = np.inf
    alone = Prior(prior.values, std)
    noise = NoiseAsMotion(problem, solution)
    factor = noise.without(alone.added(common, state), common, state)
    left = triangular_factor(factor[:, [*own, *shared, -1]])[len(own) : -1, len(own) :]
    left[:, -1] += left[:, :-1] @ state.common[shared]
    return Shared(state.beta, errors, left)


def check_disturbances_show(problem: Problem) -> None:
    """What the robot file names can be estimated from this recording.

    Raises:
        InputError: nothing of it shows, or the recording is too long for it.
    """
    followed, rows = problem.acting.followed, problem.t.size
    names = [*(followed.robot.disturbances or ())]
    walks = [name for name in followed.robot.said_to_act if name in WALKS]
    if walks and rows > LONGEST:
        raise InputError(
            f"momentum that walks at random needs 20 kB a row by maximum likelihood, "
            f"and the recording has {rows} rows of at most {LONGEST}; "
            "declare momentum_walk and use --method structured"
        )
    if names and rows > LONGEST:
        raise InputError(
            f"{names[0]} is said to act, which takes 3 kB a row, and the recording has "
            f"{rows} rows of at most {LONGEST}; use a part of it (--from, --to)"
        )
    every = {each.family for each in problem.acting.unknowns} if names else set()
    for name in [each for each in names if each not in every]:
        raise InputError(
            f"disturbance '{name}' is asked for, and shows in no "
            f"recording without {AGENTS[name].needs}; give that, or do not ask for it"
        )
