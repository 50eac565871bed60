import numpy as np
import pytest

from orbident.dynamics.wheel_limits import TAPER, WheelLimits, limited

LIMITS = WheelLimits(torque=np.array([0.1]), speed=np.array([100.0]))
NONE = WheelLimits(torque=np.array([np.inf]), speed=np.array([np.inf]))


@pytest.mark.parametrize(
    ("asked", "speed", "given"),
    [
        (0.05, 0.0, 0.05),
        (0.5, 0.0, 0.1),
        (-0.5, 0.0, -0.1),
        (0.5, 99.9, 0.1 * 0.001 / TAPER),
        (0.5, 100.0, 0.0),
        (0.5, 120.0, 0.0),
        (-0.5, 120.0, -0.1),
        (-0.5, -99.9, -0.1 * 0.001 / TAPER),
        (-0.5, -120.0, 0.0),
        (0.5, -120.0, 0.1),
        (0.0, 120.0, 0.0),
    ],
)
def test_torque_that_the_motor_gives(asked, speed, given):
    found = limited(LIMITS, np.array([asked]), np.array([speed]))
    # 1 - 0.999 has lost three digits.
    np.testing.assert_allclose(found, [given], rtol=1e-12)


@pytest.mark.parametrize("asked", [0.0, 3.0, -3.0])
def test_no_limits(asked):
    found = limited(NONE, np.array([asked]), np.array([500.0]))
    np.testing.assert_array_equal(found, [asked])
