"""Momentum that walks at random: white torque and force from outside.

White noise of the density `q` over a time `T`, as waves whose sizes are independent,

    tau(t) = c_0 sqrt(1/T) + sum_m c_m sqrt(2/T) cos(m pi t / T),   c_m ~ N(0, q^2)

Its integral is a random walk with the deviation `q sqrt(t)` (the cosines are
orthonormal; Karhunen 1947). The first `WAVES` of them leave out a part of
`1 / (pi^2 WAVES)` of its variance. A force acts through the system CM.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.followed import Followed, by_step
from orbident.estimation.output_error.forms import AXES, Disturbance, nothing
from orbident.model.inertia import inertia
from orbident.model.minimal_sets import conserved_axes
from orbident.robot.description import MomentumWalk

WALKS = ("torque_walk", "force_walk")
"""The groups of waves, in the order of `MomentumWalk`."""

WAVES = 24
"""So the walk's deviation is wrong by a fifth of a percent."""

LEAST = 1e-9
"""SI: the first guess where nothing moves."""


def walks(followed: Followed) -> Iterator[Disturbance]:
    """The waves of each walk that is declared or asked for.

    Args:
        followed: the motion that was measured.
    """
    robot, none = followed.robot, nothing(followed)
    turning, moving = conserved_axes(robot)
    guess = None
    for group, axes, density in zip(
        WALKS, (turning, moving), robot.momentum_walk, strict=True
    ):
        if group not in robot.said_to_act or (
            group == "force_walk" and not followed.tracked
        ):
            continue
        if not density:
            guess = guess or _as_large_as_the_motion(followed)
            density = getattr(guess, group.removesuffix("_walk"))
        for m, wave in enumerate(_waves(followed.t)):
            for k in axes:
                along = np.zeros((followed.t.size, 3))
                along[:, k] = wave
                effect = (
                    none._replace(torque=by_step(along))
                    if group == "torque_walk"
                    else none._replace(push=by_step(along / robot.mass))
                )
                name = f"{group}.{AXES[k]}.{m}"
                unit = f"{'N m' if group == 'torque_walk' else 'N'}/sqrt(Hz)"
                yield Disturbance(name, group, unit, effect, std=density)


def _waves(t: Float[np.ndarray, " nodes"]) -> Iterator[Float[np.ndarray, " nodes"]]:
    since, T = t - t[0], t[-1] - t[0]
    for m in range(WAVES + 1):
        yield np.sqrt((2 if m else 1) / T) * np.cos(m * np.pi * since / T)


def _as_large_as_the_motion(followed: Followed) -> MomentumWalk:
    """A first guess: so strong that it could have moved the base as it moved."""
    robot, root = followed.robot, np.sqrt(followed.t[-1] - followed.t[0])
    D = inertia(robot, followed.q[:1]).D[0]
    rate = float(np.sqrt(np.mean(followed.w**2)))
    speed = 0.0 if followed.v_S is None else float(np.sqrt(np.mean(followed.v_S**2)))
    return MomentumWalk(
        torque=max(float(np.trace(D)) * rate / root, LEAST),
        force=max(robot.mass * speed / root, LEAST),
    )
