"""What is refused of the recursive estimator's results."""

import numpy as np
from random_motions import random_motion

import orbident as oi


def test_only_a_mass_above_zero_is_accepted():
    """An accelerometer that shows zeros, and once a billion, tells no mass."""
    robot = oi.load_robot("paper-spatial")
    motion = random_motion(robot, duration=12.0)
    flight = oi.simulate(robot, motion, rate=5.0, noise="sensors")
    spoilt = np.round(flight.column("accelerometer.y"), -3)
    spoilt[20] = 1e9
    flight = flight.with_columns({"accelerometer.y": spoilt})
    result = oi.identify(robot, flight, method="recursive")
    assert result.status == "rejected" or result.mass.value > 0
