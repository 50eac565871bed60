from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.flight import (
    FlyingState,
    FreeFlying,
    Hold,
    JointPD,
    WheelSpeed,
    standing,
)
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse
from orbident.studies.planar import ideal_record, measured_record

ROBOT = load_robot("cepheus-like")
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def flown(t: np.ndarray, start: FlyingState, *pulses: Pulse) -> FreeFlying:
    return free_flying(
        ROBOT,
        t,
        start,
        Hold(np.array([0.3, -0.2])),
        JointPD(np.full(2, 0.5), np.full(2, 0.1)),
        wheels=WheelSpeed(np.array([0.002]), np.array([-50.0])),
        pulses=pulses,
        tolerance=1e-8,
    )


@pytest.fixture(scope="module")
def flight() -> FreeFlying:
    """The second half of a flight, with the wheel turned already."""
    base = BaseState(np.zeros(3), LEVEL, np.zeros(3), np.zeros(1))
    half = flown(np.arange(101) / 100, standing(base, np.zeros(2)))
    return flown(np.arange(101) / 100, half.state(-1), Pulse("t1", 0.2, 0.5, 0.4))


def test_ideal_sensors_see_one_motion(flight: FreeFlying):
    """Each rate is the derivative of what it is the rate of, by SciPy."""
    seen = ideal_record(ROBOT, flight)
    calm = (flight.t > 0.6) & (flight.t < 0.95)
    pairs = [
        ("joint.joint1.position", "joint.joint1.velocity"),
        ("joint.joint2.position", "joint.joint2.velocity"),
        ("wheel.rw.position", "wheel.rw.speed"),
        ("position.x", "velocity.x"),
        ("position.y", "velocity.y"),
    ]
    for position, rate in pairs:
        found = CubicSpline(flight.t, seen.column(position))(flight.t, 1)
        # h^3 of the fourth derivative, 1e-6 times some 10/s^3 of the arm's swing.
        np.testing.assert_allclose(found[calm], seen.column(rate)[calm], atol=2e-5)
    R_WB = Rotation.from_quat(seen.vector("attitude", "xyzw"))
    a_S = CubicSpline(flight.t, seen.vector("velocity"))(flight.t, 1)
    felt = R_WB.apply(seen.vector("accelerometer"))
    np.testing.assert_allclose(a_S[calm], felt[calm], atol=2e-4)


def test_wheel_angles_count_from_the_first_row(flight: FreeFlying):
    assert flight.q_rw[0, 0] < -1.0
    assert ideal_record(ROBOT, flight).column("wheel.rw.position")[0] == 0.0


def test_thrust_is_known_and_the_rest_is_measured(flight: FreeFlying):
    seen = measured_record(ROBOT, flight, seed=1)
    names = {name.partition(".")[0] for name in seen.columns}
    assert names == {"joint", "wheel", "attitude", "position", "force", "torque"}
    np.testing.assert_array_equal(seen.vector("force"), flight.force)
    np.testing.assert_array_equal(seen.vector("torque"), flight.torque)
    error = seen.vector("position") - flight.r_S
    # The robot file's 0.1 mm; of 303 numbers, to three times 1/sqrt(606).
    assert error.std() == pytest.approx(1e-4, rel=0.13)


def test_exact_sensors_see_what_ideal_ones_do(flight: FreeFlying):
    sensors = {
        "joints": {"position": 0.0},
        "wheels": {"position": 0.0},
        "attitude": {"angle": 0.0},
        "position": {"std": 0.0},
        "gyro": {},
        "accelerometer": {},
    }
    ideal = ideal_record(ROBOT, flight)
    exact = measured_record(
        replace(ROBOT, sensors=declared_sensors(sensors)), flight, seed=1
    )
    for name, values in exact.columns.items():
        # Quaternions are normalised once more.
        np.testing.assert_allclose(values, ideal.column(name), atol=1e-15)
