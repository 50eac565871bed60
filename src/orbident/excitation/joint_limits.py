"""Joint motions of Eq. 41 with given ends as a linear space, and their limits in it.

Each row is a limit at a node: `slack = room - normals y`, over the size of the limit,
so that 1 is the middle and 0 the limit itself.

With the ends fixed, positions and rates are linear in the coefficients `a, b`. But the
quintic nearly cancels a slow harmonic, so some coefficients may be a hundred times
larger than the motion they make: a search over `a, b` never gets there. Here a motion
is `y`, coordinates in which the rate has mean square 1, over the joint's limit.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag
from scipy.optimize import linprog

from orbident.errors import InputError
from orbident.excitation.conditions import Conditions, Limits
from orbident.robot.joint_schema import CoupledJoints
from orbident.trajectories.trajectory import FourierQuintic

NEGLIGIBLE = 1e-4
"""A rate whose coefficients are ten thousand times larger is not worth its digits."""

Histories = tuple[
    Float[np.ndarray, "n columns"],
    Float[np.ndarray, "n columns"],
    Float[np.ndarray, "n columns"],
]
"""Position, rate and acceleration."""


class JointMotions(NamedTuple):
    """Histories at some times: an offset, and what each coordinate adds to it."""

    t: Float[np.ndarray, " n"]
    offset: Histories
    """Histories of each joint with all `a` and `b` zero."""
    basis: Histories
    """Histories of a joint whose rate limit is 1, for each coordinate of `y`."""
    scale: Float[np.ndarray, " free"]
    """The rate limits."""
    coupled: CoupledJoints
    ab_of_y: Float[np.ndarray, "2harmonics m"]
    without_series: FourierQuintic
    """What `offset` are the values of."""

    def resampled(self, nodes: int) -> "JointMotions":
        """These motions at so many times, evenly spaced over the duration."""
        offset = self.without_series
        t = np.linspace(0.0, offset.duration, nodes)
        a, b = np.split(self.ab_of_y.T, 2, axis=1)
        still = np.zeros((len(a), 3))
        basis = FourierQuintic(a, b, still, still, offset.duration)
        return self._replace(t=t, offset=offset.at(t), basis=basis.at(t))

    @property
    def harmonics(self) -> int:
        """N_f."""
        return len(self.ab_of_y) // 2

    @property
    def _gain(self) -> Float[np.ndarray, "joints free"]:
        return self.coupled.lead * self.scale

    def along(
        self, y: Float[np.ndarray, "free m"]
    ) -> tuple[Float[np.ndarray, "n joints"], Float[np.ndarray, "n joints"]]:
        """Positions and rates."""
        scaled = (self._gain @ y).T
        return self.offset[0] + self.basis[0] @ scaled, (
            self.offset[1] + self.basis[1] @ scaled
        )

    def pull_back(
        self, by_q: Float[np.ndarray, "n joints"], by_qd: Float[np.ndarray, "n joints"]
    ) -> Float[np.ndarray, "free m"]:
        """The gradient with respect to `y`."""
        return self._gain.T @ (by_q.T @ self.basis[0] + by_qd.T @ self.basis[1])

    def coefficients(
        self, y: Float[np.ndarray, "free m"]
    ) -> tuple[Float[np.ndarray, "joints N_f"], Float[np.ndarray, "joints N_f"]]:
        """`a` and `b` of Eq. 41."""
        a, b = np.hsplit(self._gain @ (y @ self.ab_of_y.T), 2)
        return a, b


def joint_motions(
    given: Conditions, coupled: CoupledJoints, nodes: int
) -> JointMotions:
    """The motions between two states of the joints.

    The nodes are evenly spaced from 0 to the duration.
    """
    assert given.harmonics is not None
    duration, harmonics = given.duration, given.harmonics
    t = np.linspace(0.0, duration, nodes)
    none = np.zeros((len(given.start), harmonics))
    offset = FourierQuintic(none, none, given.start, given.end, duration)
    still = np.zeros((2 * harmonics, 3))
    a, b = np.hsplit(np.eye(2 * harmonics), 2)
    rates = FourierQuintic(a, b, still, still, duration).derivative(1, t)
    _, s, Vt = np.linalg.svd(rates / np.sqrt(nodes), full_matrices=False)
    kept = s > NEGLIGIBLE * s[0]
    ab_of_y = Vt[kept].T / s[kept]
    empty = offset.at(t[:0])
    scale = given.limits.velocity[coupled.free]
    return JointMotions(t[:0], empty, empty, scale, coupled, ab_of_y, offset).resampled(
        nodes
    )


# Kept back from the limits: between nodes a motion goes a little beyond its nodes.
KEPT_BACK = 5e-4
QUANTITIES = ("position", "velocity", "acceleration")


class Polytope(NamedTuple):
    """`normals y <= room`, joint by joint."""

    normals: Float[np.ndarray, "free rows m"]
    room: Float[np.ndarray, "free rows"]

    @property
    def rows(self) -> Float[np.ndarray, "all_rows all_m"]:
        """The normals as one matrix, over the coordinates of all joints in turn."""
        return np.asarray(block_diag(*self.normals))

    def slack(self, y: Float[np.ndarray, "free m"]) -> Float[np.ndarray, "free r"]:
        """How far each limit is; above zero inside."""
        return self.room - np.einsum("krm,km->kr", self.normals, y)

    def reach(
        self, y: Float[np.ndarray, "free m"], step: Float[np.ndarray, "joints m"]
    ) -> Float[np.ndarray, " free"]:
        """How many steps each joint can take from an inner point."""
        towards = np.einsum("krm,km->kr", self.normals, step)
        with np.errstate(divide="ignore"):
            steps = np.where(towards > 0, self.slack(y) / towards, np.inf)
        return steps.min(axis=1)


def polytope_of(motions: JointMotions, limits: Limits) -> Polytope:
    """The joint limits at the inner nodes; at the ends nothing can be changed.

    Of the joints that follow none: their limits hold those of their followers.
    """
    free = motions.coupled.free
    position = limits.position[free]
    bounded = np.asarray(np.isfinite(position).all(axis=1))
    lower, upper = np.where(bounded[:, None], position, 0.0).T
    middle = (upper + lower) / 2
    sizes = (
        np.where(bounded, (upper - lower) / 2, np.inf),
        limits.velocity[free],
        limits.acceleration[free],
    )
    middles = (middle, np.zeros_like(middle), np.zeros_like(middle))
    normals, room = [], []
    for offset, basis, size, centre in zip(
        motions.offset, motions.basis, sizes, middles, strict=True
    ):
        reach = motions.scale / (size * (1 - KEPT_BACK))
        direction = reach[:, None, None] * basis[1:-1]
        here = ((offset[1:-1, free] - centre) / (size * (1 - KEPT_BACK))).T
        normals += [direction, -direction]
        room += [1 - here, 1 + here]
    return Polytope(np.concatenate(normals, axis=1), np.concatenate(room, axis=1))


def inner_point(
    polytope: Polytope, limits: Limits, names: Mapping[int, str]
) -> Float[np.ndarray, "free m"]:
    """The motion that stays farthest from all of its limits.

    Polytope and names are of the joints that follow none; names are by their number
    among all joints, as limits are.

    Raises:
        InputError: none stays within them; which limit, and by how much. Or their
            sizes are so different that numbers of 64 bits do not tell.
    """
    points = []
    for (k, name), normals, room in zip(
        names.items(), polytope.normals, polytope.room, strict=True
    ):
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
