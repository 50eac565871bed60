"""What free-flying robots are given to do in tests: torques, thrusters, a start."""

from collections.abc import Sequence

import numpy as np
from random_robots import random_start, random_unit_vector

from orbident.robot.description import Robot, Thruster
from orbident.simulation.flight import FlyingState, OpenLoop, standing


def waving(seed: int, count: int) -> OpenLoop:
    """Torques that swing as sines: half a newton metre at some radians a second."""
    random = np.random.default_rng(seed)
    amplitude = random.uniform(0.2, 0.8, count)
    rate = random.uniform(1.0, 4.0, count)
    return OpenLoop(lambda t: amplitude * np.sin(np.multiply.outer(t, rate) + 1.0))


def random_thrusters(seed: int, names: Sequence[str]) -> tuple[Thruster, ...]:
    """Anywhere on the base, in any direction."""
    random = np.random.default_rng(seed)
    return tuple(
        Thruster(name, random.standard_normal(3), random_unit_vector(random))
        for name in names
    )


def moving_start(seed: int, robot: Robot) -> FlyingState:
    """Base and joints move, wheels spin."""
    random = np.random.default_rng(seed)
    q, qd = 0.3 * random.standard_normal((2, len(robot.joints)))
    return standing(random_start(seed, robot), q)._replace(qd=qd)
