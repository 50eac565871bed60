"""A base that turns against one wheel, whose tachometer has noise.

In closed form: with the wheel's speed `u`, a sum of sines, the base turns at the rate
`w = w_0 - I (u - u_0) / D`, and its angle is the integral of that. Where the speed
varies by some ten times its noise, least squares of `w` over the speeds that were read
finds `D` some hundredths too large (Fuller 1987, section 1.1).
"""

import numpy as np
import pytest

from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

D, WHEEL, NOISE, RATE = 20.0, 0.02, 0.03, 20.0
"""kg m^2 of base and of wheel; rad/s; Hz."""
WALK, ANGLE = 2e-6, 1e-4
"""rad/sqrt(s) of the gyro, rad of the attitude."""
SEEDS = 8


def robot(wheels: dict[str, float]) -> Robot:
    """CAD has the inertia 10 % too large.

    Args:
        wheels: what is declared of their sensors.
    """
    inertia = [1.1 * D] * 3
    return load_robot(
        {
            "schema": "orbident/robot/1",
            "name": "table",
            "motion": "planar",
            "feature_point": [0, 0, 0],
            "bodies": {"base": {"mass": 50, "com": [0, 0, 0], "inertia": inertia}},
            "wheels": [{"name": "w", "axis": [0, 0, 1], "inertia": WHEEL}],
            "sensors": {
                "rate": RATE,
                "gyro": {"angle_random_walk": WALK},
                "attitude": {"angle": ANGLE},
                **({"wheels": wheels} if wheels else {}),
            },
        }
    )


def recording(seed: int) -> Recording:
    random = np.random.default_rng(seed)
    t = np.arange(0, 40, 1 / RATE)
    rate, phase = 2 * np.pi * np.linspace(0.2, 2.0, 12), random.uniform(0, 6, 12)
    size = 0.1 * random.normal(size=12)
    speed = np.sin(np.outer(t, rate) + phase) @ size
    turned = (np.cos(phase) - np.cos(np.outer(t, rate) + phase)) @ (size / rate)
    w = 0.01 - WHEEL / D * (speed - speed[0])
    angle = 0.01 * t - WHEEL / D * (turned - speed[0] * t)
    angle += ANGLE * random.normal(size=t.size)
    nothing = np.zeros(t.size)
    columns = {
        "wheel.w.speed": 100 + speed + NOISE * random.normal(size=t.size),
        "gyro.x": nothing,
        "gyro.y": nothing,
        "gyro.z": w + WALK * np.sqrt(RATE) * random.normal(size=t.size),
        "attitude.x": nothing,
        "attitude.y": nothing,
        "attitude.z": np.sin(angle / 2),
        "attitude.w": np.cos(angle / 2),
    }
    return Recording(t, columns, f"table {seed}")


@pytest.mark.parametrize("declared", [{"tachometer": NOISE}, {}])
def test_noise_of_a_tachometer_makes_no_base_larger(declared: dict[str, float]):
    """It had been 4.2 deviations too large in the mean, and was accepted."""
    table = robot(declared)
    results = [identify(table, recording(seed)) for seed in range(SEEDS)]
    assert {result.status for result in results} == {"ok"}
    off = np.array([(x.pi.values[0] - D) / x.pi.std[0] for x in results])
    assert np.abs(off).max() < 4
    # Of as many normal errors the mean is within four of its own deviations.
    assert abs(off.mean()) < 4 / np.sqrt(SEEDS)
