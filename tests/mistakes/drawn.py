"""A kind of mistake whose size, place and time are drawn at random.

The words that name each were written before any was tried: what somebody who made the
mistake would accept as its name.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from mistake import Mistake
from recordings import Clean

Random = np.random.Generator
Draw = Callable[[Clean, Random], Mistake]


class Kind(NamedTuple):
    """One kind of mistake."""

    draw: Draw
    space: bool = True
    """Whether it is tried in space, and on the table."""
    table: bool = True
    wheels: int = 1
    """So many wheels the robot has at least."""

    @property
    def name(self) -> str:
        """That of the function which draws it."""
        return self.draw.__name__.replace("_", " ")


def joint_of(clean: Clean, random: Random) -> str:
    return str(random.choice(clean.robot.joint_names))


def either(random: Random) -> float:
    """A sign."""
    return float(random.choice([-1.0, 1.0]))


def between(random: Random, low: float, high: float) -> float:
    """Two digits, evenly in the logarithm."""
    return float(f"{np.exp(random.uniform(np.log(low), np.log(high))):.2g}")


def middle(clean: Clean, random: Random) -> float:
    """A time that is neither near the start nor near the end, s; on a row."""
    return float(clean.t[int(random.uniform(0.3, 0.7) * clean.t.size)])


def direction(clean: Clean, random: Random) -> np.ndarray:
    """A random unit vector: any in space, one in the plane on a table."""
    v = random.standard_normal(3) * (1.0, 1.0, 1.0 if clean.space else 0.0)
    return v / np.linalg.norm(v)


def about(clean: Clean, random: Random) -> np.ndarray:
    """An axis to turn about: on a table the vertical."""
    return direction(clean, random) if clean.space else np.array([0.0, 0.0, 1.0])
