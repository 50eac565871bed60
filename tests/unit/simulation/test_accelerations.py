from dataclasses import replace

import numpy as np
import pytest
from random_robots import (
    random_planar_robot,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)

from orbident.model.rotations import quaternion_matrix
from orbident.simulation.free_floating import free_floating
from orbident.simulation.measure import accelerations

PARENTS = (0, 1, 0)
SWING = random_swing(2, len(PARENTS))
Z = np.array([0.0, 0.0, 1.0])
ROBOTS = {
    "held and free wheels": random_robot(
        1, PARENTS, prismatic=(2,), wheels=random_wheels(1, ("held", "free", "free"))
    ),
    "no wheels": random_robot(4, PARENTS),
    "planar": random_planar_robot(
        5,
        PARENTS,
        prismatic=(1,),
        wheels=[replace(w, axis=Z) for w in random_wheels(2, ("held", "free"))],
    ),
}
H = 5e-3


def central(x: np.ndarray) -> np.ndarray:
    """The derivative by the seven-point formula of sixth order, at the inner rows."""
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * H)
    windows = [x[k : len(x) - 6 + k] for k in range(7)]
    return np.tensordot(weights, windows, axes=1)


@pytest.mark.parametrize("name", ROBOTS)
def test_accelerations_are_derivatives_of_the_velocities(name):
    robot = ROBOTS[name]
    t = np.arange(0.0, 3.0, H)
    start = random_start(3, robot)
    motion = free_floating(robot, SWING, t, start, tolerance=1e-12)
    ours = accelerations(robot, motion, SWING.at(t)[2])
    wheels = slice(6 + len(robot.joints), None)
    R_WB = quaternion_matrix(motion.attitude)[3:-3]
    f_S = np.einsum("nji,nj->ni", R_WB, central(motion.v_S))
    # Rounding divided by H, of wheel speeds of hundreds of rad/s; the formula is off by
    # H^6 x^(7) / 140. Seen: 2e-13, and 4e-12 for the wheels.
    for found, expected in (
        (ours.v_dot[:, 3:6], central(motion.w)),
        (ours.v_dot[:, wheels], central(motion.qd_rw)),
        (ours.f_S, f_S),
    ):
        scale = max(1.0, np.abs(expected).max(initial=0.0))
        np.testing.assert_allclose(found[3:-3], expected, rtol=0, atol=1e-10 * scale)
    assert np.abs(f_S).max() > 0.01


def test_planar_robots_accelerate_in_their_plane():
    robot = ROBOTS["planar"]
    t = np.arange(0.0, 1.0, 0.1)
    motion = free_floating(robot, SWING, t, random_start(3, robot))
    ours = accelerations(robot, motion, SWING.at(t)[2])
    assert not ours.v_dot[:, 3:5].any()
    # Rounding.
    np.testing.assert_allclose(ours.f_S[:, 2], 0.0, atol=1e-14)
