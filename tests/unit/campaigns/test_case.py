from pathlib import Path

import numpy as np
import pytest
from instruments import Errors, shown_with
from small_campaigns import begun

from orbident.campaigns.case import Case, Draws, moved_joints, with_instrument_errors
from orbident.errors import InputError
from orbident.robot.description import Robot
from orbident.robot.parameters import inertia_about_com
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.simulation.measure import truth_of
from orbident.simulation.simulate import motion_recording

ALL = {
    "inertia": {"normal": 0.1},
    "instruments": {"normal": 1},
    "noise": {"uniform": [-0.5, 0.5]},
    "initial": {
        "angular_velocity": {"normal": 0.01},
        "velocity": {"normal": 0.1},
        "attitude": {"normal": 0.2},
        "wheel_speed": {"normal": 5},
    },
}

MOTION = {"robot": "robot.yaml", "trajectory": "motion.yaml"}


def case(folder: Path, k: int = 3, **changes) -> Case:
    campaign, _ = begun(folder, **{"disperse": ALL, **changes})
    return campaign.case(k)


def test_the_number_of_a_run_decides_all_that_is_drawn(tmp_path: Path):
    found = case(tmp_path / "a")
    same = case(tmp_path / "b", runs=100, chunk=7, methods=["recursive"])
    assert found.draws == same.draws
    again = same.recording().columns.items()
    assert all(np.array_equal(found.recording().column(n), x) for n, x in again)
    assert found.draws != case(tmp_path / "a", k=4).draws
    assert found.draws != case(tmp_path / "c", entropy=2).draws


def test_seeds_are_children_of_the_entropy(tmp_path: Path):
    words = np.random.SeedSequence(1, spawn_key=(3,)).generate_state(4)
    assert case(tmp_path).seed == int.from_bytes(words.tobytes(), "little")


def test_a_quantity_that_is_left_out_changes_no_other(tmp_path: Path):
    every = case(tmp_path / "a").draws
    rest = {name: x for name, x in ALL.items() if name != "inertia"}
    left = case(tmp_path / "b", disperse=rest).draws
    assert left == {n: x for n, x in every.items() if not n.startswith("inertia.")}


def test_what_flies_is_dispersed_and_what_is_told_is_not(tmp_path: Path):
    found = case(tmp_path)
    declared, true = found.subject.robot, found.robot
    mass = np.exp(found.draws["inertia.link1.mass"])
    np.testing.assert_allclose(true.theta[1, 0], mass * declared.theta[1, 0], 1e-14)
    louder = np.exp(found.draws["noise.gyro"])
    sizes = [robot.sensors.of("gyro").white_std() for robot in (true, declared)]
    assert sizes[0] == louder * sizes[1]
    before, now = found.subject.trajectory.initial, found.trajectory.initial
    by = [found.draws[f"initial.angular_velocity.{k}"] for k in "xyz"]
    np.testing.assert_array_equal(now.angular_velocity, before.angular_velocity + by)


def test_no_draw_makes_a_body_that_cannot_exist(tmp_path: Path):
    widely = case(tmp_path, disperse={"inertia": {"signs": 3.0}})
    for theta_i in widely.robot.theta:
        a, b, c = np.linalg.eigvalsh(inertia_about_com(theta_i))
        assert theta_i[0] > 0
        # Rounding of moments that Huygens-Steiner adds and takes away.
        assert -1e-9 * c < a <= b <= c <= (a + b) * (1 + 1e-9)


def errors_of(robot: Robot, draws: Draws) -> Errors:
    """The same errors, as the reference takes them."""

    def some(*names: str) -> np.ndarray:
        return np.array([draws.get(f"instruments.{name}", 0.0) for name in names])

    def axes(name: str) -> list[str]:
        return [f"{name}.{axis}" for axis in "xyz"]

    joints, wheels = robot.joint_names, robot.wheel_names
    return Errors(
        zero=some(*(f"joint.{name}.zero" for name in joints)),
        scale=some(*(f"joint.{name}.scale" for name in joints)),
        wheel=some(*(f"wheel.{name}.inertia" for name in wheels)),
        axis=some(*(a for n in wheels for a in axes(f"wheel.{n}.axis"))),
        feature_point=some(*axes("feature_point")),
        attitude=some(*axes("attitude.misalignment")),
        gyro=some(*axes("gyro.misalignment")),
        gyro_scale=some(*axes("gyro.scale")),
        position=some("position.scale"),
        clock=some(*(f"{key}.clock" for key in ("joints", "attitude", "position"))),
        place=some(*(a for n in joints for a in axes(f"joint.{n}.place"))),
        direction=some(*(a for n in joints for a in axes(f"joint.{n}.direction"))),
    )


def test_instruments_err_as_the_reference_has_it(tmp_path: Path):
    """That of the tests of the estimator, which was written for itself."""
    found = case(tmp_path)
    robot, motion = found.subject.robot, found.subject.trajectory
    names = {name.partition(".")[2]: x for name, x in found.draws.items()}
    assert {"joint.joint1.zero", "gyro.scale.x", "joints.clock"} <= set(names)
    # Not declared, so not drawn: all of them are to be compared.
    names |= {"position.scale": 0.01, "attitude.clock": 1e-3, "position.clock": 1e-3}
    names |= {f"attitude.misalignment.{axis}": 0.003 for axis in "xyz"}
    errors = errors_of(robot, {f"instruments.{name}": x for name, x in names.items()})
    moved = moved_joints(robot, names)
    for joint, reference in zip(moved.joints, errors.robot(robot).joints, strict=True):
        # A rotation by 2 sin(angle / 2) or by the angle: 1e-9 of a milliradian cubed.
        np.testing.assert_allclose(joint.R_PJ, reference.R_PJ, atol=1e-9)
        np.testing.assert_allclose(joint.p_PJ, reference.p_PJ, atol=1e-15)
    for wheel, reference in zip(moved.wheels, errors.robot(robot).wheels, strict=True):
        np.testing.assert_allclose(wheel.axis, reference.axis, atol=1e-9)

    t = np.arange(0.0, 10.0, 0.05)
    w, ahead = np.array([0.01, 0.02, 0.03]), np.array([0.0, 0.0, 0.0, 1.0])
    start = BaseState(w, ahead, np.ones(3), 100 * np.ones(3))
    flight = free_floating(robot, motion, t, start, 1e-9)
    reference = shown_with(errors, robot, motion_recording(robot, flight))
    seen = with_instrument_errors(
        robot, t, truth_of(robot, flight, motion), names
    ).columns(robot)
    for name, column in reference.columns.items():
        if name.startswith("wheel."):
            continue
        # A clock that is late by 1 ms: here the quintic through the samples, there one
        # step along the rate, off by half the acceleration, 1e-6 of it.
        np.testing.assert_allclose(seen[name], column, atol=2e-6, err_msg=name)


def test_what_acts_flies_with_the_run(tmp_path: Path):
    """The noise of the sensors is the same, and the base turns otherwise."""
    slow = {"std": 0.1, "correlation_time": 5}
    robots = [MOTION | {"environment": {"slow_torque": slow}}]
    turned = case(tmp_path / "one", disperse={}, robots=robots).recording()
    alone = case(tmp_path / "other", disperse={}).recording()
    difference = turned.column("gyro.x") - alone.column("gyro.x")
    assert abs(difference[0]) < 1e-15
    assert np.abs(difference).max() > 1e-5


def test_an_environment_of_another_robot_is_refused(tmp_path: Path):
    robots = [MOTION | {"environment": {"tilt": [1e-5, 0]}}]
    with pytest.raises(InputError, match=r"robots\[0\]: environment: 'tilt'"):
        case(tmp_path, robots=robots)
