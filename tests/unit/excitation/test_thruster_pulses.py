"""Pulses that excite a satellite without joints, and what is promised of them."""

from pathlib import Path

import numpy as np
import pytest
from valved_satellite import ARMS, PUSHES, THRUST, satellite

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.excitation.bound import bound_of
from orbident.excitation.conditions import conditions_for, limits_of
from orbident.excitation.design import design_excitation, design_recordings
from orbident.excitation.table_points import TableSize
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import motion_table, simulate, times_to_the_end

SENSORS = (
    "sensors:\n  position: {std: 0.3 mm, rate: 20}\n"
    "  attitude: {angle: 0.5 mrad, rate: 20}\n"
)


def designed(robot: Robot, duration: float = 15.0, starts: int = 2, **limits):
    given = conditions_for(robot, duration, limits=limits_of(robot, **limits))
    return design_excitation(robot, starts=starts, conditions=given)


def summed(duty: dict[str, np.ndarray], dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Yaw rate and place of the nominal satellite by plain sums, from rest at zero."""
    on = np.column_stack([duty[f"thruster.t{k}.duty"] for k in range(1, 9)])
    force = THRUST * on[:, :, None] * PUSHES
    torque = np.sum(ARMS[:, 0] * force[..., 1] - ARMS[:, 1] * force[..., 0], axis=1)
    w = np.cumsum(torque / 0.3) * dt
    yaw = np.cumsum(w) * dt
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = force.sum(axis=1).T
    a = np.column_stack([c * x - s * y, s * x + c * y]) / 20.0
    return w, np.cumsum(np.cumsum(a, axis=0), axis=0) * dt**2


@pytest.mark.slow
def test_limits_are_kept_by_a_flight_of_plain_sums(tmp_path: Path):
    robot = satellite(tmp_path, more=SENSORS)
    motion = designed(robot, table=TableSize(0.5, 0.3), base_rate=0.4, impulse=5.0)
    table = motion_table(motion, times_to_the_end(motion, 1000.0))
    duty = {name: table.column(name) for name in table.columns}
    assert set(np.round(np.concatenate([*duty.values()]), 9)) == {0.0, 1.0}
    w, place = summed(duty | {n: 0 * table.t for n in absent(duty)}, 1e-3)
    assert np.abs(w).max() < 0.4 * 1.01
    assert np.all(np.ptp(place, axis=0) < np.array([0.5, 0.3]) * 1.01)
    assert THRUST * sum(map(np.sum, duty.values())) * 1e-3 < 5.0 * 1.01
    assert motion.design
    found = motion.design["extremes"]
    assert np.abs(w).max() == pytest.approx(found["rate"], rel=0.01)
    assert np.ptp(place, axis=0) == pytest.approx(found["table"][:2], rel=0.03)


def absent(duty: dict[str, np.ndarray]) -> set[str]:
    return {f"thruster.t{k}.duty" for k in range(1, 9)} - duty.keys()


def test_the_bound_is_what_identify_then_gives(tmp_path: Path):
    robot = satellite(tmp_path, more=SENSORS)
    motion = designed(robot)
    bound = bound_of(robot, motion).parameters.base.covariance
    result = identify(robot, simulate(robot, motion, noise="sensors", seed=3))
    assert result.status == "ok", result.warnings
    assert result.base.std == pytest.approx(np.sqrt(np.diag(bound)), rel=0.1)


@pytest.mark.slow
def test_the_best_of_many_is_better_than_most(tmp_path: Path):
    robot = satellite(tmp_path, more=SENSORS)
    made = designed(robot, starts=4).design
    assert made
    assert made["value"] < 0.9 * made["median_random_start"]
    assert made["starts"] == 4


@pytest.mark.long
def test_in_space_with_wheels(tmp_path: Path):
    """Six thrusters on a box whose wheels spin: all ten parameters have a bound."""
    ways = [(k, s) for k in range(3) for s in (1.0, -1.0)]
    jets = "".join(
        f"  - {{name: t{n}, position: {np.roll([0.4, 0.2, 0.1], k).tolist()}, "
        f"direction: {(s * np.eye(3)[k]).tolist()}, thrust: 0.5}}\n"
        for n, (k, s) in enumerate(ways)
    )
    path = tmp_path / "box.yaml"
    path.write_text(
        "schema: orbident/robot/1\nname: box\n"
        "bodies:\n  box: {mass: 50 kg, inertia: [4, 5, 6]}\n"
        f"thrusters:\n{jets}"
        "wheels:\n  - {name: w, axis: [0, 0, 1], inertia: 0.01}\n"
        f"{SENSORS}  wheels: {{tachometer: 0.01, rate: 20}}\n"
    )
    robot = load_robot(path)
    motion = designed(robot, 8.0, starts=1, base_rate=0.5)
    assert bound_of(robot, motion).parameters.base.determined.all()
    with pytest.raises(InputError, match="flies in space"):
        designed(robot, table=TableSize(1.0, 1.0))
    # They spin at 200 rad/s from the start.
    with pytest.raises(InputError, match="none of 20 random sequences"):
        designed(robot, duration=2.0, wheel_speed=100.0)


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"objective": "cond"}, "objective cond"),
        ({"uncertainty": 0.1}, "uncertainty"),
        ({"harmonics": 3}, "harmonics"),
    ],
)
def test_what_only_joints_are_designed_for(tmp_path: Path, wish, words):
    with pytest.raises(InputError, match=words):
        design_excitation(satellite(tmp_path, more=SENSORS), **wish)


@pytest.mark.slow
def test_refused_in_one_line(tmp_path: Path):
    robot = satellite(tmp_path, more=SENSORS)
    with pytest.raises(InputError, match="several recordings"):
        next(design_recordings(robot, 2, conditions_for(robot, 30.0)))
    with pytest.raises(InputError, match="none of 20 random sequences"):
        designed(robot, 1.0, impulse=1e-9)
    with pytest.raises(InputError, match="found no noise"):
        designed(satellite(tmp_path))
    with pytest.raises(InputError, match="impulse limit: thrusters are fired only"):
        limits_of(load_robot("cepheus-like"), impulse=1.0)
