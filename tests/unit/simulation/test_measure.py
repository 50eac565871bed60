from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.simulation.measure import measure_truth, truth_of
from orbident.simulation.simulate import sample_times, simulate

EVERYTHING = {
    "gyro": {"angle_random_walk": 3e-6, "bias_instability": 1.5e-6},
    "accelerometer": {"velocity_random_walk": 2e-5, "bias_instability": 1e-4},
    "joints": {"position": 2.5e-5},
    "wheels": {"position": 2.5e-5},
    "attitude": {"angle": 2e-5},
    "position": {"std": 1e-4},
}
EXACT = {
    "gyro": {},
    "accelerometer": {},
    "joints": {"position": 0.0},
    "wheels": {"position": 0.0},
    "attitude": {"angle": 0.0},
    "position": {"std": 0.0},
}
ROBOT = load_robot("paper-spatial")
FREE = replace(
    ROBOT, wheels=tuple(replace(wheel, mode="free") for wheel in ROBOT.wheels)
)
TRAJECTORY = random_motion(ROBOT, duration=10.0)


def motion_of(robot, rate=20.0):
    initial = TRAJECTORY.initial
    start = BaseState(
        angular_velocity=initial.angular_velocity,
        attitude=initial.attitude,
        velocity=initial.velocity,
        wheel_speed=initial.wheel_speeds(robot.wheel_names),
    )
    return free_floating(robot, TRAJECTORY, sample_times(10.0, rate), start)


MOTION = motion_of(ROBOT)


def with_sensors(sensors, robot=ROBOT):
    return replace(robot, sensors=declared_sensors(sensors))


def measure(robot, motion, seed=0, truth=False):
    true = truth_of(robot, motion, TRAJECTORY.for_robot(robot))
    return measure_truth(robot, motion.t, true, seed, truth)


def measured(sensors, seed=0, **options):
    return measure(with_sensors(sensors), MOTION, seed, **options)


def test_all_that_is_declared_is_measured_and_nothing_else():
    columns = {f"joint.{name}.position" for name in ROBOT.joint_names}
    assert set(measured({}).columns) == columns
    columns |= {f"wheel.{name}.position" for name in ROBOT.wheel_names}
    for sensor in ("gyro", "accelerometer", "position"):
        columns |= {f"{sensor}.{axis}" for axis in "xyz"}
    columns |= {f"attitude.{axis}" for axis in "xyzw"}
    assert set(measured(EVERYTHING).columns) == columns


def test_joint_positions_are_exact_without_encoders():
    np.testing.assert_array_equal(
        measured({}).column("joint.joint2.position"), MOTION.q[:, 1]
    )


@pytest.mark.parametrize("robot", [ROBOT, FREE], ids=["held wheels", "free wheels"])
def test_exact_sensors_show_the_truth(robot):
    motion = motion_of(robot)
    recording = measure(with_sensors(EXACT, robot), motion, truth=True)
    for name, values in recording.columns.items():
        if not name.startswith("truth."):
            # The attitude is normalised once more: rounding.
            np.testing.assert_allclose(
                values, recording.column(f"truth.{name}"), rtol=0, atol=1e-15
            )
    ideal = simulate(robot, TRAJECTORY, rate=20.0)
    for name, values in ideal.columns.items():
        np.testing.assert_array_equal(recording.column(f"truth.{name}"), values)


@pytest.mark.parametrize("robot", [ROBOT, FREE], ids=["held wheels", "free wheels"])
def test_wheel_angles_are_integrals_of_the_wheel_speeds(robot):
    def angles(rate):
        motion = motion_of(robot, rate)
        recording = measure(with_sensors(EXACT, robot), motion, truth=True)
        columns = ("truth.wheel.rw_y.position", "truth.wheel.rw_y.speed")
        return np.column_stack([recording.column(name) for name in columns])

    rare, often = angles(20.0), angles(200.0)
    assert rare[0, 0] == 0.0
    # h^4 / 720 of the change of the third derivative: some 1e-8 at 20 Hz, 1e4 times
    # less at 200 Hz. An encoder is a thousand times coarser.
    np.testing.assert_allclose(rare[:, 0], often[::10, 0], rtol=0, atol=2e-7)
    turned = np.sum(0.005 * (often[1:, 1] + often[:-1, 1]) / 2)
    # The plain trapezoidal rule, of second order.
    assert often[-1, 0] == pytest.approx(turned, abs=1e-6)


def test_the_accelerometer_integrates_to_the_velocity():
    motion = motion_of(ROBOT, 200.0)
    recording = measure(with_sensors(EXACT), motion)
    R_WB = np.asarray(quaternion_matrix(motion.attitude))
    a_S = np.einsum("nij,nj->ni", R_WB, recording.vector("accelerometer"))
    change = 0.005 * (a_S[1:] + a_S[:-1]).sum(axis=0) / 2
    # The trapezoidal rule: h^2 / 12 of the change of a_S', which is below 1.
    np.testing.assert_allclose(change, motion.v_S[-1] - motion.v_S[0], atol=2e-6)


def test_increments_sum_to_the_velocity():
    sensors = {"accelerometer": {"increments": True, "rate": 10.0}}
    recording = measured(sensors, truth=True)
    assert not recording.has("accelerometer.x")
    increments = recording.vector("velocity_increment")[::2]
    assert np.isnan(recording.vector("velocity_increment")[1::2]).all()
    R_WB = np.asarray(quaternion_matrix(MOTION.attitude))[::2]
    change = np.einsum("nij,nj->i", R_WB[:-1], increments[1:])
    np.testing.assert_allclose(change, MOTION.v_S[-1] - MOTION.v_S[0], atol=1e-13)


def test_the_same_seed_gives_the_same_recording_and_another_one_does_not():
    first, again, other = (measured(EVERYTHING, seed) for seed in (7, 7, 8))
    for name, values in first.columns.items():
        np.testing.assert_array_equal(values, again.column(name))
        assert (values != other.column(name)).any()


def test_a_sensor_does_not_change_another_ones_noise():
    both = measured(EVERYTHING, 3)
    changed = EVERYTHING | {"gyro": {"angle_random_walk": 1e-3, "drop_out": 0.5}}
    for sensors in (changed, {"joints": EVERYTHING["joints"]}):
        for name, values in measured(sensors, 3).columns.items():
            if not name.startswith("gyro"):
                np.testing.assert_array_equal(values, both.column(name))


def test_drop_outs_leave_the_other_samples_as_they_were():
    whole = measured(EVERYTHING).column("gyro.y")
    holed = measured(
        EVERYTHING | {"gyro": EVERYTHING["gyro"] | {"drop_out": 0.3}}
    ).column("gyro.y")
    left = np.isfinite(holed)
    assert 0 < left.sum() < left.size
    np.testing.assert_array_equal(holed[left], whole[left])


def test_every_encoder_and_every_sensor_has_noise_of_its_own():
    recording = measured(EVERYTHING, truth=True)
    noise = [
        values - recording.column(f"truth.{name}")
        for name, values in recording.columns.items()
        if name.endswith((".position", "gyro.x", "gyro.y", "position.x"))
        and not name.startswith("truth.")
    ]
    correlation = np.abs(np.corrcoef(noise) - np.eye(len(noise)))
    # 201 samples: std 0.07 of a correlation.
    assert correlation.max() < 0.35


def test_noise_has_the_size_that_the_section_says():
    recording = measured(EVERYTHING, truth=True)
    joints = [f"joint.{name}.position" for name in ROBOT.joint_names]
    error = [recording.column(j) - recording.column(f"truth.{j}") for j in joints]
    # 603 samples: 2.9 %.
    assert np.std(error) == pytest.approx(2.5e-5, rel=0.12)


def test_each_sensor_has_its_own_rate():
    sensors = EVERYTHING | {"attitude": {"angle": 0.0, "rate": 2.0}}
    recording = measured(sensors)
    rows = np.flatnonzero(np.isfinite(recording.column("attitude.w")))
    np.testing.assert_array_equal(rows, np.arange(0, 201, 10))
    assert np.isfinite(recording.column("gyro.x")).all()


def test_a_rate_that_does_not_fit_names_the_sensor():
    with pytest.raises(InputError, match=r"sensors\.attitude: rate: found 3 Hz"):
        measured({"attitude": {"angle": 0.0, "rate": 3.0}})


@pytest.mark.parametrize("seed", [-1, True])
def test_a_bad_seed_is_refused(seed):
    with pytest.raises(InputError, match=r"seed .*: give a whole number"):
        measured(EVERYTHING, seed)


def test_simulate_measures_when_asked():
    robot = with_sensors(EVERYTHING | {"rate": 20.0})
    recording = simulate(robot, TRAJECTORY, noise="sensors", seed=5)
    np.testing.assert_array_equal(
        recording.column("gyro.x"), measured(EVERYTHING, 5).column("gyro.x")
    )
    assert "wheel.rw_x.speed" in simulate(robot, TRAJECTORY, seed=5).columns


def test_a_joint_with_a_torque_constant_shows_its_current():
    """`current = torque / constant`, and so is its noise."""
    one, *others = ROBOT.joint_names
    motors = replace(ROBOT, torque_constants={one: 2.5})
    exact = with_sensors({"torques": {"std": 0.0}}, motors)
    true = measure(exact, MOTION, truth=True).columns
    np.testing.assert_allclose(
        2.5 * true[f"joint.{one}.current"], true[f"truth.joint.{one}.torque"]
    )
    assert f"joint.{one}.torque" not in true
    assert all(f"joint.{name}.torque" in true for name in others)
    noisy = measure(with_sensors({"torques": {"std": 0.1}}, motors), MOTION).columns
    error = noisy[f"joint.{one}.current"] - true[f"joint.{one}.current"]
    # Of 201 samples: a deviation is known to 5 %.
    assert np.std(error) == pytest.approx(0.1 / 2.5, rel=0.2)
    # Nothing is shown that nobody asked for.
    assert not any("current" in name for name in measure(motors, MOTION).columns)
