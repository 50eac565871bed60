"""The joint limits, which are linear in the coordinates of a motion.

Each row is a limit at a node: `slack = room - normals y`, over the size of the limit,
so that 1 is the middle and 0 the limit itself.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag
from scipy.optimize import linprog

from orbident.errors import InputError
from orbident.excitation.conditions import Limits
from orbident.excitation.joint_motions import JointMotions

# Kept back from the limits: between nodes a motion goes a little beyond its nodes.
KEPT_BACK = 5e-4
QUANTITIES = ("position", "velocity", "acceleration")


class Polytope(NamedTuple):
    """`normals y <= room`, joint by joint."""

    normals: Float[np.ndarray, "joints rows m"]
    room: Float[np.ndarray, "joints rows"]

    @property
    def rows(self) -> Float[np.ndarray, "all_rows all_m"]:
        """The normals as one matrix, over the coordinates of all joints in turn."""
        return np.asarray(block_diag(*self.normals))

    def slack(self, y: Float[np.ndarray, "joints m"]) -> Float[np.ndarray, "joints r"]:
        """How far each limit is; above zero inside."""
        return self.room - np.einsum("krm,km->kr", self.normals, y)

    def reach(
        self, y: Float[np.ndarray, "joints m"], step: Float[np.ndarray, "joints m"]
    ) -> Float[np.ndarray, " joints"]:
        """How many steps each joint can take from an inner point."""
        towards = np.einsum("krm,km->kr", self.normals, step)
        with np.errstate(divide="ignore"):
            steps = np.where(towards > 0, self.slack(y) / towards, np.inf)
        return steps.min(axis=1)


def polytope_of(motions: JointMotions, limits: Limits) -> Polytope:
    """The joint limits at the inner nodes; at the ends nothing can be changed."""
    bounded = np.asarray(np.isfinite(limits.position).all(axis=1))
    lower, upper = np.where(bounded[:, None], limits.position, 0.0).T
    middle = (upper + lower) / 2
    sizes = (
        np.where(bounded, (upper - lower) / 2, np.inf),
        limits.velocity,
        limits.acceleration,
    )
    middles = (middle, np.zeros_like(middle), np.zeros_like(middle))
    normals, room = [], []
    for offset, basis, size, centre in zip(
        motions.offset, motions.basis, sizes, middles, strict=True
    ):
        reach = motions.scale / (size * (1 - KEPT_BACK))
        direction = reach[:, None, None] * basis[1:-1]
        here = ((offset[1:-1] - centre) / (size * (1 - KEPT_BACK))).T
        normals += [direction, -direction]
        room += [1 - here, 1 + here]
    return Polytope(np.concatenate(normals, axis=1), np.concatenate(room, axis=1))


def inner_point(
    polytope: Polytope, limits: Limits, names: tuple[str, ...]
) -> Float[np.ndarray, "joints m"]:
    """The motion that stays farthest from all of its limits.

    Raises:
        InputError: none stays within them; which limit, and by how much. Or their
            sizes are so different that numbers of 64 bits do not tell.
    """
    points = []
    for k, name in enumerate(names):
        normals, room = polytope.normals[k], polytope.room[k]
        m = normals.shape[1]
        # Maximise the least slack, s: normals y + s <= room.
        found = linprog(
            np.append(np.zeros(m), -1.0),
            A_ub=np.column_stack([normals, np.ones(len(room))]),
            b_ub=room,
            bounds=[(None, None)] * (m + 1),
        )
        if found.x is None:
            raise InputError(
                f"joint '{name}': no motion could be found in this duration, since one "
                "of its limits is so much narrower than another; correct the limits"
            )
        if not found.x[-1] > 0:
            # Which rows hold it back: their multipliers.
            held = np.abs(found.ineqlin.marginals).reshape(len(QUANTITIES), -1)
            _refuse(name, int(held.sum(axis=1).argmax()), -found.x[-1], k, limits)
        points.append(found.x[:-1])
    return np.array(points)


def _refuse(name: str, quantity: int, excess: float, k: int, limits: Limits) -> None:
    what = QUANTITIES[quantity]
    if what == "position":
        found = f"[{limits.position[k, 0]:g}, {limits.position[k, 1]:g}]"
    else:
        found = f"{getattr(limits, what)[k]:g}"
    raise InputError(
        f"joint '{name}': {what}: no motion between the given ends stays within the "
        f"limit {found} for this duration: the gentlest exceeds it by "
        f"{100 * excess:.2g} %; give more time, or other ends"
    )


def check_ends(
    names: tuple[str, ...],
    limits: Limits,
    start: Float[np.ndarray, "joints 3"],
    end: Float[np.ndarray, "joints 3"],
) -> None:
    """Refuse to start or end outside the limits, or at one.

    Raises:
        InputError: so; which limit, and by how much.
    """
    lower, upper = limits.position.T
    ranges = (
        (lower, upper),
        (-limits.velocity, limits.velocity),
        (-limits.acceleration, limits.acceleration),
    )
    for when, state in (("start", start), ("end", end)):
        for what, (low, high), values in zip(QUANTITIES, ranges, state.T, strict=True):
            size = np.where(np.isfinite(high - low), high - low, 0.0)
            beyond = np.maximum(low - values, values - high) + KEPT_BACK * size
            k = int(beyond.argmax())
            if beyond[k] > 0:
                raise InputError(
                    f"joint '{names[k]}': {what} at the {when}: found {values[k]:g}, "
                    f"{beyond[k]:.2g} too far; give one within [{low[k]:g}, "
                    f"{high[k]:g}], not at its ends"
                )
