"""The minimal sets of any robot reproduce its momentum, and say what they are."""

import math
import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious_momentum import system_motion
from random_robots import random_planar_robot, random_robot

from orbident.model.formulas import formulas_of, mass_forms
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Axis, Robot
from orbident.robot.parameters import Structure

JOINTS, STATES = 3, 6
# The sets are found over normalised columns whose distance from one another is 1e-3
# at least: inverting them may cost three of sixteen digits. The worst observed, over
# 150 robots of one to five joints, is 5e-15 of the sum of the terms' sizes.
TOLERANCE = 1e-12


class Recipe(NamedTuple):
    """Any tree; links may slide, be massless, or have a known structure.

    The robot is made from it in the test: strategies must not use random numbers,
    which the run-time checks of its functions do.
    """

    planar: bool
    seed: int
    parents: tuple[int, ...]
    prismatic: set[int]
    massless: set[int]
    com_on_axis: dict[int, Axis]
    principal_axes: set[int]

    def robot(self) -> Robot:
        make = random_planar_robot if self.planar else random_robot
        robot = make(self.seed, self.parents, sorted(self.prismatic))
        known = {
            body: Structure(self.com_on_axis.get(k), k in self.principal_axes)
            for k, body in enumerate(robot.bodies[1:])
        }
        robot = replace(robot, structure=known)
        # What the structure says is true of the robot.
        theta = np.zeros(robot.theta.size)
        free = list(robot.free_parameters)
        theta[free] = robot.theta.ravel()[free]
        theta = theta.reshape(robot.theta.shape)
        theta[[k + 1 for k in self.massless]] = 0.0
        return replace(robot, theta=theta)


joints = st.integers(0, JOINTS - 1)
recipes = st.builds(
    Recipe,
    planar=st.booleans(),
    seed=st.integers(0, 999),
    parents=st.tuples(*(st.integers(0, k) for k in range(JOINTS))),
    prismatic=st.sets(joints),
    massless=st.sets(joints),
    com_on_axis=st.dictionaries(joints, st.sampled_from(["x", "y", "z"])),
    principal_axes=st.sets(joints),
)


def random_states(robot: Robot):
    random = np.random.default_rng(7)
    q, qd = random.standard_normal((2, STATES, len(robot.joints)))
    w = random.standard_normal((STATES, 3))
    if robot.motion == "planar":
        w[:, :2] = 0.0
    return q, qd, w


def check_momentum_and_velocity(robot: Robot, sets: MinimalSets):
    """`Y pi = h_rs` (Eq. 19) and `W phi = -P theta / M` (Eq. 29)."""
    q, qd, w = random_states(robot)
    Y, W = sets.regressors(q, qd, w)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    turning = list(sets.regressors.momentum_axes)
    moving = list(sets.regressors.velocity_axes)
    for k in range(STATES):
        total = system_motion(robot, q[k], qd[k], w[k])
        assert_close(Y[k] @ pi, total.h_rs[turning], np.abs(Y[k]) @ np.abs(pi))
        v = -total.linear[moving] / robot.mass
        assert_close(W[k] @ phi, v, np.abs(W[k]) @ np.abs(phi))


def assert_close(ours, theirs, terms):
    assert np.abs(ours - theirs).max() <= TOLERANCE * max(np.max(terms), 1.0)


def check_coordinates(robot: Robot, sets: MinimalSets):
    """`beta` has a `theta`, and the first of `pi` hold an `iota` each."""
    base, betas = sets.base, sets.base.T.shape[0]
    assert betas == 1 + base.sigmas + sets.iotas
    # Both are exact but for the inverse of T's pivots.
    np.testing.assert_allclose(base.T @ base.theta_of, np.eye(betas), atol=TOLERANCE)
    of_iota = sets.pi_of_beta[:, 1 + base.sigmas :]
    np.testing.assert_array_equal(of_iota[: sets.iotas], np.eye(sets.iotas))
    np.testing.assert_array_equal(of_iota[sets.iotas :], 0.0)
    # What the structure makes zero enters nothing.
    known = np.setdiff1d(np.arange(base.T.shape[1]), robot.free_parameters)
    np.testing.assert_array_equal(base.T[:, known], 0.0)
    np.testing.assert_array_equal(base.theta_of[known], 0.0)
    # The first of beta is the total mass; the split puts it together again.
    beta = sets.beta(robot.theta)
    M, sigma, iota = sets.split(beta)
    np.testing.assert_allclose(M, robot.mass, rtol=TOLERANCE)
    np.testing.assert_array_equal(np.concatenate([[M], sigma, iota]), beta)


def check_same_momentum_for_same_beta(robot: Robot, sets: MinimalSets):
    """Another `theta` of the same `beta` cannot be told apart."""
    twin = (sets.base.theta_of @ sets.beta(robot.theta)).reshape(robot.theta.shape)
    q, qd, w = random_states(robot)
    turning = list(sets.regressors.momentum_axes)
    moving = list(sets.regressors.velocity_axes)
    for state in zip(q, qd, w, strict=True):
        a, b = (
            system_motion(replace(robot, theta=x), *state) for x in (robot.theta, twin)
        )
        size = max(np.abs(robot.theta).max(), np.abs(twin).max()) * 10
        assert_close(a.h_rs[turning], b.h_rs[turning], size)
        assert_close(a.linear[moving], b.linear[moving], size)


def evaluate(formula: str, values: dict[str, float]) -> tuple[float, float]:
    """A formula's value, and the sum of its terms' sizes."""
    if quotient := re.fullmatch(r"\((.*)\)/M", formula):
        value, size = evaluate(quotient[1], values)
        return value / values["M"], size / values["M"]
    first, *others = re.split(r" ([+-]) ", formula)
    negative = first.startswith("-")
    terms = [("-" if negative else "+", first.removeprefix("-"))]
    terms += zip(others[::2], others[1::2], strict=True)
    numbers = [
        (-1 if sign == "-" else 1) * term_of(text, values) for sign, text in terms
    ]
    return sum(numbers), sum(map(abs, numbers))


def term_of(text: str, values: dict[str, float]) -> float:
    """`2.5 sigma_1 sigma_2/M`, `sigma_1^2/M`, `mx(base)`, `0`."""
    divisor = 1.0
    if text.endswith("/M"):
        text, divisor = text.removesuffix("/M"), values["M"]
    factors = []
    for word in text.split(" "):
        name, _, power = word.partition("^")
        number = values[name] if name in values else float(name)
        factors.append(number ** int(power or 1))
    return math.prod(factors) / divisor


def check_formulas(robot: Robot, sets: MinimalSets):
    """What is printed evaluates to the numbers; coefficients have four digits."""
    formulas = formulas_of(robot, sets)
    symbols = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
    values = {
        f"{symbol}({body})": float(number)
        for body, row in zip(robot.bodies, robot.theta, strict=True)
        for symbol, number in zip(symbols, row, strict=True)
    }
    # Their joints may have motors behind gears; these have none.
    values |= {f"rotor({name})": 0.0 for name in robot.joint_names}
    beta, phi = sets.beta(robot.theta), sets.phi(robot.theta)
    values |= zip(formulas.base.names, beta.tolist(), strict=True)
    values |= zip(formulas.phi.names, phi.tolist(), strict=True)
    pairs = [
        (formulas.base, beta),
        (formulas.phi, phi),
        (formulas.pi, sets.pi(robot.theta)),
    ]
    for described, numbers in pairs:
        assert len(described.names) == len(described.formulas) == len(numbers)
        for formula, number in zip(described.formulas, numbers, strict=True):
            value, size = evaluate(formula, values)
            # Rounding to four digits is off by 5e-4 of a coefficient at most.
            assert abs(value - number) <= 5e-4 * size + 1e-9
    # g_i(phi) is what pi / M holds without inertia (Eq. 32).
    pi = sets.pi(robot.theta)
    pure = np.eye(pi.size)[sets.iotas :]
    forms = mass_forms(sets, pure, formulas)
    for i, (name, formula) in enumerate(zip(*forms, strict=True), start=sets.iotas):
        divisor = formula.removeprefix(f"{name}/(").removesuffix(")")
        value, size = evaluate(divisor, values)
        number = pi[i] / robot.mass
        assert abs(value - number) <= 5e-4 * size + 1e-9


def check(robot: Robot):
    sets = minimal_sets(robot)
    check_momentum_and_velocity(robot, sets)
    check_coordinates(robot, sets)
    check_same_momentum_for_same_beta(robot, sets)
    check_formulas(robot, sets)


@settings(max_examples=15)
@given(recipes)
def test_any_robot(recipe):
    check(recipe.robot())


def test_no_joints():
    check(random_robot(0, ()))


def test_only_sliding_joints():
    """A prismatic chain turns as one body: six inertias of the base alone."""
    robot = random_robot(0, (0, 1, 2), (0, 1, 2))
    check(robot)


def test_massless_links_between_joints_in_one_point():
    """A spherical wrist: three axes through one point, mass behind it only."""
    robot = random_robot(1, (0, 1, 2))
    joints = [
        joint if k == 0 else replace(joint, p_PJ=np.zeros(3))
        for k, joint in enumerate(robot.joints)
    ]
    theta = robot.theta.copy()
    theta[1:3] = 0.0
    check(replace(robot, joints=tuple(joints), theta=theta))
