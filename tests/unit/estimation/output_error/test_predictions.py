"""What sensors should show: the simulator's values, and their derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from instruments import no_errors, random_errors
from random_robots import (
    random_parents,
    random_planar_robot,
    random_robot,
    random_wheels,
)
from segments import Segment, segment_of

from orbident.estimation.output_error.problem import SENSORS
from orbident.estimation.solution import Unknowns
from orbident.robot.description import Robot

ROBOTS = {
    "spatial": random_robot(
        1, (0, 1, 0), prismatic=(1,), wheels=random_wheels(1, ["held", "free", "held"])
    ),
    "planar": random_planar_robot(
        2, (0, 1), prismatic=(1,), wheels=random_wheels(2, ["held"])
    ),
}

SLOW_IN_SPACE = [pytest.param("spatial", marks=pytest.mark.slow), "planar"]


@pytest.fixture(scope="module", params=ROBOTS)
def segment(request) -> Segment:
    return segment_of(ROBOTS[request.param], seed=3, rows=33)


def changed(state: Unknowns, z: np.ndarray, g: np.ndarray) -> Unknowns:
    """The state with other unknowns; a turn of any size, in one step."""
    moved = state.moved(z, g)
    return moved._replace(local=np.ascontiguousarray(moved.local))


def by_differences(segment: Segment, sensor: str) -> np.ndarray:
    """How what a sensor shows less what is predicted falls with each unknown."""
    state, step = segment.state, 1e-4
    shape, common = state.local.shape, state.common.size
    rows = np.count_nonzero(segment.weights[sensor])
    columns = []
    for e in np.eye(state.local.size + common):
        z, g = e[:-common].reshape(shape), e[-common:]

        def shown(size, z=z, g=g):
            at = changed(state, size * z, size * g)
            return segment.equations(sensor, state=at)[:rows, -1]

        one, two = (shown(-k * step) - shown(k * step) for k in (1, 2))
        columns.append((8 * one - two) / (12 * step))
    return np.array(columns).T


def check_slopes(segment: Segment, faster: float = 1.0, of: str = "") -> None:
    """`faster`: how many times as fast as usual joints swing; `of`: one sensor."""
    # Of an acceleration slopes are by a parabola in time, 0.02^2; of a late velocity
    # they have that many times those.
    felt = by_differences(segment, "accelerometer")
    shares = {"accelerometer": 1.0, "velocity": abs(segment.late)}
    for sensor in [of] if of else segment.weights:
        if sensor == "joints" or (sensor == "attitude" and faster > 1):
            # The slopes of a rotation's residual are those of a small one.
            continue
        exact = by_differences(segment, sensor)
        ours = segment.equations(sensor)[: len(exact), :-1]
        # RK4 of the derivative is not the derivative of RK4: a step's error, 0.02^4
        # relative; and rounding over the differences' step.
        share = shares.get(sensor, 0.0)
        part, least = 1e-7 * faster**4, 1e-9 + 1e-4 * share
        error = np.abs(ours - exact).max(axis=0)
        local = segment.state.local.size
        betas = local + 15 + segment.state.beta.size
        for group in (
            slice(0, local),
            slice(local, local + 15),
            slice(local + 15, betas),
            slice(betas, None),
        ):
            size = np.abs(exact[:, group]).max(initial=0.0)
            of_felt = np.abs(felt[:, group]).max(initial=0.0)
            most = part * size + 1e-3 * share * faster**2 * of_felt + least
            assert error[group].max(initial=0.0) < most, (sensor, group)


@pytest.mark.core
def test_values_are_the_simulators(segment: Segment):
    for sensor, residual in segment.residuals().items():
        # RK4 with 50 steps a second at some rad/s, and the simulator's own 1e-12.
        np.testing.assert_allclose(residual, 0.0, atol=1e-9, err_msg=sensor)


@pytest.mark.core
def test_a_fast_nutation_needs_smaller_steps():
    """A base that answers its wheels at 5 rad/s, sampled at 20 Hz."""
    robot = ROBOTS["spatial"]
    wheels = tuple(replace(wheel, inertia=0.5) for wheel in robot.wheels)
    robot = replace(robot, wheels=wheels)
    errors = [
        np.abs(segment_of(robot, 3, 33, 0.05, substeps).residuals()["attitude"]).max()
        for substeps in (1, 2, 16)
    ]
    # RK4: 16 times less with half the step; then what parabolas leave of the joints.
    assert errors[0] > 1e-5
    assert errors[1] < errors[0] / 8
    assert errors[2] < 1e-3 * errors[0]


def test_slopes_are_the_derivatives_of_the_values(segment: Segment):
    check_slopes(segment)


@pytest.mark.parametrize("robot", SLOW_IN_SPACE)
def test_badly_calibrated_instruments(robot):
    """Values and slopes, with every calibration error of the order of 0.05."""
    errors = random_errors(ROBOTS[robot], 7, 0.05)
    segment = segment_of(ROBOTS[robot], 3, 17, errors=errors)
    np.testing.assert_array_equal(segment.state.calibration, errors.vector)
    for sensor, residual in segment.residuals().items():
        np.testing.assert_allclose(residual, 0.0, atol=1e-9, err_msg=sensor)
    check_slopes(segment)


@pytest.mark.parametrize("robot", SLOW_IN_SPACE)
def test_a_late_velocity(robot):
    """To the last row, behind which there is none."""
    errors = no_errors(ROBOTS[robot])
    errors.clock[2] = 0.05
    segment = segment_of(ROBOTS[robot], 3, 17, errors=errors)
    np.testing.assert_allclose(segment.residuals()["velocity"], 0.0, atol=1e-9)
    check_slopes(segment, of="velocity")


@pytest.mark.parametrize("passive", [(), (1,)])
@pytest.mark.parametrize("robot", SLOW_IN_SPACE)
def test_torques_at_joints(robot, passive):
    """Their means, as the simulator's inverse dynamics have them, and slopes."""
    joints = len(ROBOTS[robot].joints)
    drives = 0.1 * np.random.default_rng(5).standard_normal((5, joints))
    # What is passive has no encoder, and no errors of one.
    errors = None if passive else random_errors(ROBOTS[robot], 7, 0.05)
    segment = segment_of(
        ROBOTS[robot], 3, 17, errors=errors, passive=passive, drives=drives
    )
    if not passive:
        left = segment.residuals()["torques"]
        assert np.count_nonzero(segment.weights["torques"]) == joints
        # Simpson's rule with 50 rows a second, of torques of some N m.
        np.testing.assert_allclose(left, 0.0, atol=1e-6)
    check_slopes(segment, 2.0 if passive else 1.0, of="torques")


@pytest.mark.core
def test_a_selected_calibration_has_the_column_that_it_has_among_all():
    """Calibrations are selected in any order; what is not selected is exact."""
    robot = ROBOTS["spatial"]
    perfect = segment_of(robot, 3, 9)
    count = random_errors(robot, 0, 1.0).vector.size
    places = np.random.default_rng(0).permutation(count)[:5].astype(float)
    sensors = [name for name in SENSORS if name != "joints"]
    own = perfect.equations(*sensors)
    every = perfect.state.selecting(np.arange(count, dtype=float))
    all_of_them = perfect.equations(*sensors, state=every)
    some = perfect.equations(*sensors, state=perfect.state.selecting(places))
    before = own.shape[1] - 1
    np.testing.assert_array_equal(some[:, :before], own[:, :before])
    chosen = all_of_them[:, before + places.astype(int)]
    np.testing.assert_array_equal(some[:, before:-1], chosen)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(
    seed=st.integers(0, 2**20),
    joints=st.integers(1, 4),
    planar=st.booleans(),
    slides=st.integers(0, 15),
    massless=st.integers(0, 15),
)
def test_any_tree(seed, joints, planar, slides, massless):
    """Values and slopes, with massless links and slides, some base far heavier."""
    robot = any_robot(seed, joints, planar, slides, massless)
    segment = segment_of(robot, seed, rows=17)
    for sensor, residual in segment.residuals().items():
        # The base may turn at some rad/s.
        np.testing.assert_allclose(residual, 0.0, atol=1e-6, err_msg=sensor)
    check_slopes(segment)


def any_robot(seed, joints, planar, slides, massless) -> Robot:
    parents = random_parents(np.random.default_rng(seed), joints)
    sliding = tuple(k for k in range(joints) if slides >> k & 1)
    wheels = random_wheels(seed, ["held"])
    if planar:
        robot = random_planar_robot(seed, parents, sliding, wheels)
    else:
        robot = random_robot(seed, parents, sliding, wheels, base=10.0)
    theta = robot.theta.copy()
    theta[[k + 1 for k in range(joints) if massless >> k & 1]] = 0.0
    return replace(robot, theta=theta)


@pytest.mark.parametrize("robot", SLOW_IN_SPACE)
def test_slopes_with_passive_joints(robot):
    """One that slides and one that turns; springs and all errors are unknowns."""
    robot = ROBOTS[robot]
    errors = random_errors(robot, 7, 0.05)
    segment = segment_of(robot, 3, 9, 0.005, 2, errors=errors, passive=(0, 1))
    joints, places = len(robot.joints), segment.recorded.places
    encoders = [0, 1, joints, joints + 1]
    errors = np.setdiff1d(np.arange(errors.vector.size), encoders)
    # Behind them are errors of torques.
    springs = places - 7 * joints + np.arange(2 * joints)
    state = segment.state.carried(np.append(errors, springs).astype(float))
    check_slopes(segment._replace(state=state), faster=2.0)


@pytest.mark.parametrize("robot", SLOW_IN_SPACE)
def test_slopes_with_a_joint_that_follows(robot):
    """It moves with the corrections of the first one, which swings or does not."""
    robot = ROBOTS[robot]
    last = len(robot.joints) - 1
    for passive in ((), *([(1,)] if last > 1 else [])):
        drives = np.zeros((5, last + 1))
        segment = segment_of(
            robot,
            *(3, 33, 0.005, 2),
            passive=passive,
            drives=drives,
            follows=[(last, 0, -2.5)],
        )
        random = np.random.default_rng(4)
        local = segment.state.local.copy()
        local[:, 9:] += 0.1 * random.standard_normal(local[:, 9:].shape)
        state = segment.state._replace(local=local)
        check_slopes(segment._replace(state=state), faster=2.0)


@pytest.mark.parametrize("substeps", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_slopes_with_smaller_steps(substeps):
    check_slopes(segment_of(ROBOTS["spatial"], 3, 33, substeps=substeps))


@pytest.mark.core
def test_continuity_and_corrections(segment: Segment):
    """The interval's end is the next one's start; corrections have a prior."""
    state, rows = segment.state, 0
    table = segment.equations()
    L = state.local.shape[1]
    continuity = table[rows : rows + 9]
    duration = 0.02 * 32
    np.testing.assert_allclose(continuity[:, -1], 0.0, atol=1e-8)
    size = 1 / np.sqrt(duration)
    np.testing.assert_allclose(continuity[:, L : L + 9], -size * np.eye(9), rtol=1e-12)
    np.testing.assert_allclose(continuity[3:, 3:9], size * np.eye(6), rtol=1e-12)
    prior = table[9:]
    N = prior.T @ prior
    expected = np.zeros(len(N))
    expected[L + 9 : 2 * L] = 1.0
    np.testing.assert_allclose(N, np.diag(expected), atol=1e-12)
