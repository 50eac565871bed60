"""What a search minimises: a criterion, over all plausible robots, within limits."""

from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from orbident.excitation.conditions import Conditions, Limits
from orbident.excitation.criterion import (
    Basis,
    Objective,
    Y_hat,
    add_Y_hat,
    basis_of,
    by_matrix,
    log_criterion,
    smooth_maximum,
    spectrum_of,
    spectrum_of_rows,
)
from orbident.excitation.floating import (
    Craft,
    Gradient,
    NodalMotion,
    craft_of,
    nutation,
    was_at_rest,
)
from orbident.excitation.information import (
    Information,
    Sensing,
    of_parameters,
    sensing_of,
)
from orbident.excitation.joint_limits import JointMotions, Polytope, joint_motions
from orbident.excitation.table_points import (
    TABLE_SIZES,
    add_points,
    points_on_table,
    use_of_table,
)
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.joint_schema import coupled_joints
from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS

STEPS = 64
"""The fewest steps of the grid."""

A_PERIOD = 16
"""Steps in a period of the highest harmonic."""

FINER_FOR_SENSORS = 4
"""Times as many steps: differences over longer ones make accelerations too small."""

STEP_ANGLE = 0.3
"""Turn of the base, or of its nutation, in a step, rad: RK4 is wrong by 2e-5 rad."""

OFF_THE_EDGE = STEP_ANGLE**2 / 8
"""Share of a table that is kept free: on a circle, a point goes so far beyond nodes."""

MOST_STEPS = 8192
"""More would need minutes a start; what is then wrong shows in the final score."""

WELL_INSIDE = 0.8
"""Square of the share of a limit that leaves room for a motion to search from."""

MOST_STEPS_INSIDE = 30
"""The most steps of a descent to a motion inside the limits; it took 10 to 20 where
there was one."""

LIMITS_POWER = 2000.0
"""Power of the mean that stands for the largest use of a limit: it is 0.5 % above it at
most."""


class Candidate(NamedTuple):
    """One trajectory; logarithms of the worst robot's criterion."""

    smooth: float
    gradient: Float[np.ndarray, "free m"]
    exact: float
    used: Float[np.ndarray, " limits"]
    """Share of each limit of the base that is used, squared, by a smooth maximum."""
    used_gradient: Float[np.ndarray, "limits free m"]


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """All that stays the same while trajectories are compared."""

    crafts: tuple[Craft, ...]
    """Every plausible robot; the first is the nominal one."""
    motions: JointMotions
    """The joint motions at nodes and mid-nodes."""
    limits: Limits
    objective: Objective
    basis: Basis
    sensing: Sensing | None
    """None for the objective cond."""
    at_rest: bool
    known: Float[np.ndarray, "common common"] | float
    """Information that other recordings give; zero without any."""

    @property
    def limited(self) -> tuple[str, ...]:
        """The limits of the base that there are."""
        most = {"excursion": np.pi}
        if not self.crafts[0].wheels.free.size:
            most["wheel speed"] = 0.0
        limits = self.limits.by_name.items()
        return tuple(name for name, size in limits if size < most.get(name, np.inf))

    def evaluate(self, y: Float[np.ndarray, "free m"], p: float) -> Candidate:
        """The criterion and the use of the limits, with their gradients.

        Means of power `p` stand for extremes.
        """
        motions = self._along(y)
        values, gradients = zip(*(self._criterion(m, p) for m in motions), strict=True)
        smooth, exact = np.array(values).T
        # The worst robot by the mean of power p, as for eigenvalues.
        worst, shares = smooth_maximum(smooth, p)
        gradient = sum(
            share * self._by_y(f) for share, f in zip(shares, gradients, strict=True)
        )
        used, by_y = self._all_used(motions)
        return Candidate(worst, np.asarray(gradient), float(exact.max()), used, by_y)

    def gentlest(
        self, polytope: Polytope, middle: Float[np.ndarray, "free m"]
    ) -> Float[np.ndarray, "free m"]:
        """A motion that is well inside the limits of the base, or as far as can be.

        It is `middle`, a motion inside the joints' limits, where the base allows that.
        """
        shape = middle.shape

        def used(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            values, by_y = self._all_used(self._along(x[:-1].reshape(shape)))
            return values, by_y.reshape(len(values), middle.size)

        # Without a series, joints go straight from end to end: often they rest.
        inside = [
            np.append(y.ravel(), 0.0)
            for y in (middle, np.zeros(shape))
            if polytope.slack(y).min() > 0
        ]
        for x in inside:
            x[-1] = used(x)[0].max(initial=0.0)
            if x[-1] < 1:
                return x[:-1].reshape(shape)
        start = min(inside, key=lambda x: x[-1])
        rows, room = polytope.rows, polytope.room.ravel()
        room = room - polytope.slack(start[:-1].reshape(shape)).min() / 2

        def slacks(x: np.ndarray) -> np.ndarray:
            return np.concatenate([x[-1] - used(x)[0], room - rows @ x[:-1]])

        def slack_gradients(x: np.ndarray) -> np.ndarray:
            by_y = np.concatenate([-used(x)[1], -rows])
            least = np.arange(len(by_y)) < len(self.limited)
            return np.column_stack([by_y, least])

        # Minimise s, which all that is used is below.
        found = minimize(
            lambda x: (x[-1], np.append(np.zeros(x.size - 1), 1.0)),
            start,
            jac=True,
            method="SLSQP",
            bounds=[(None, None)] * middle.size + [(WELL_INSIDE, None)],
            options={"maxiter": MOST_STEPS_INSIDE},
            constraints={"type": "ineq", "fun": slacks, "jac": slack_gradients},
        )
        return found.x[:-1].reshape(shape)

    def _along(self, y: Float[np.ndarray, "free m"]) -> list[NodalMotion]:
        """The motion of each robot."""
        q, qd = self.motions.along(y)
        dt = 2 * float(self.motions.t[1])
        return [craft.along(q, qd, dt) for craft in self.crafts]

    def _by_y(self, f: Gradient) -> Float[np.ndarray, "free m"]:
        return self.motions.pull_back(*f.motion.craft.pull_back(f))

    def _criterion(
        self, motion: NodalMotion, p: float
    ) -> tuple[tuple[float, float], Gradient]:
        """The logarithm, smooth and exact, and the gradient of the smooth one."""
        f = Gradient(motion)
        if self.sensing is None:
            pi_of, regressors = self.basis.pi_of, motion.craft.sets.regressors
            axes = regressors.momentum_axes
            # Trapezoidal weights: as on a grid so fine that its ends do not count.
            weights = np.ones((len(motion.w), len(axes)))
            weights[[0, -1]] = np.sqrt(0.5)
            weights = weights.reshape(-1, 1)
            rows = weights * Y_hat(motion, pi_of, axes, self.at_rest)
            spectrum = spectrum_of_rows(rows)
            value = log_criterion(self.objective, spectrum.l, p)
            by_rows = weights * (2 * rows @ by_matrix(spectrum, value.by_l))
            add_Y_hat(f, by_rows, pi_of, axes, self.at_rest)
        else:
            information = Information(self.sensing, motion, self.at_rest)
            F, left = of_parameters(self.sensing, information.F + self.known)
            spectrum = spectrum_of(F)
            value = log_criterion(self.objective, spectrum.l, p)
            information.add(f, left @ by_matrix(spectrum, value.by_l) @ left.T)
        return (value.smooth, value.exact), f

    def _all_used(
        self, motions: list[NodalMotion]
    ) -> tuple[Float[np.ndarray, " limits"], Float[np.ndarray, "limits free m"]]:
        used = [self._used(name, motions) for name in self.limited]
        shape = len(used), len(self.motions.scale), self.motions.basis[0].shape[1]
        return (
            np.array([value for value, _ in used]),
            np.reshape([by_y for _, by_y in used], shape),
        )

    def _used(
        self, name: str, motions: list[NodalMotion]
    ) -> tuple[float, Float[np.ndarray, "free m"]]:
        """The largest square of the share of a limit, of all robots; its gradient."""
        uses = np.array([self._use(name, motion) for motion in motions])
        if name in TABLE_SIZES:
            size = self.limits.by_name[name] * (1 - OFF_THE_EDGE)
            most, by_uses = use_of_table(name, size, uses, LIMITS_POWER)
        else:
            most, by_uses = smooth_maximum(uses, LIMITS_POWER)
        gradient = np.zeros((len(self.motions.scale), self.motions.basis[0].shape[1]))
        for motion, by_use in zip(motions, by_uses, strict=True):
            f = Gradient(motion)
            self._add_use(f, name, by_use)
            gradient += self._by_y(f)
        return most, gradient

    def _use(self, name: str, motion: NodalMotion) -> Float[np.ndarray, "n uses ..."]:
        """The square of the share of a limit, node by node; of a table, the points."""
        if name == "base rate":
            return (motion.w**2).sum(axis=1, keepdims=True) / self.limits.base_rate**2
        if name == "wheel speed":
            return (motion.qd_rw / self.limits.wheel_speed) ** 2
        if name in TABLE_SIZES:
            robot = motion.craft.robot
            return points_on_table(robot, motion.q, motion.R, motion.r_S)
        # sin^2 of half the angle: (3 - tr R_0^T R) / 4.
        trace = np.einsum("ij,nij->n", motion.R[0], motion.R)[:, None]
        return (3 - trace) / 4 / np.sin(self.limits.excursion / 2) ** 2

    def _add_use(
        self, f: Gradient, name: str, by_use: Float[np.ndarray, "n uses ..."]
    ) -> None:
        motion = f.motion
        if name == "base rate":
            f.w += by_use * 2 * motion.w / self.limits.base_rate**2
        elif name == "wheel speed":
            by_speed = by_use * 2 * motion.qd_rw / self.limits.wheel_speed**2
            wheels = self.crafts[0].wheels
            f.w -= (by_speed * wheels.free) @ wheels.axes.T
        elif name in TABLE_SIZES:
            add_points(f, by_use)
        else:
            scale = 4 * np.sin(self.limits.excursion / 2) ** 2
            f.R -= by_use[:, :, None] * motion.R[0] / scale


def problem_for(
    robot: Robot,
    given: Conditions,
    objective: Objective,
    uncertainty: float,
    known: Float[np.ndarray, "common common"] | float = 0.0,
) -> DesignProblem:
    """What is minimised, for the nominal robot and those that could be the true one.

    The uncertainty is as of `plausible_robots`; `known` is the information that other
    recordings give, of the nominal robot.

    Raises:
        InputError: the objective needs sensors that the robot file does not have.
    """
    sets = minimal_sets(robot)
    at_rest = was_at_rest(robot, given.initial, given.start)
    return DesignProblem(
        crafts=tuple(
            craft_of(each, sets, given.initial, given.start, at_rest)
            for each in plausible_robots(robot, uncertainty)
        ),
        motions=joint_motions(
            given,
            coupled_joints(robot),
            nodes=2 * steps_for(robot, given, objective) + 1,
        ),
        limits=given.limits,
        objective=objective,
        basis=given.basis or basis_of(robot, sets),
        sensing=None if objective == "cond" else sensing_of(robot, sets),
        at_rest=at_rest,
        known=known,
    )


def steps_for(robot: Robot, given: Conditions, objective: Objective) -> int:
    """Steps that follow the harmonics, the tumbling and the nutation of the base.

    Even where sensors count: what acts from outside is known from two steps to two.
    """
    assert given.harmonics is not None
    sets = minimal_sets(robot)
    turned = nutation(robot, given.initial, given.start) * given.duration
    if min(given.limits.table) < np.inf:
        # In the plane points go round with the base and the joints.
        rates = given.limits.velocity[coupled_joints(robot).free]
        spin = np.abs(given.initial.angular_velocity[2])
        turned = float(spin + rates.sum()) * given.duration
    # Twice as many rows as unknowns: fewer would let rounding excite them.
    pis, betas = sets.pi_of_beta.shape
    unknowns = pis if objective == "cond" else betas
    axes = len(sets.regressors.momentum_axes)
    steps = max(STEPS, A_PERIOD * given.harmonics)
    if objective != "cond":
        steps *= FINER_FOR_SENSORS
    steps = max(steps, ceil(2 * unknowns / axes))
    steps = max(steps, min(ceil(turned / STEP_ANGLE), MOST_STEPS))
    return steps if objective == "cond" else 2 * ceil(steps / 2)


ROBOTS = 6
"""Plausible robots beside the nominal one: the worst of more is hardly worse."""


def plausible_robots(robot: Robot, uncertainty: float) -> list[Robot]:
    """Each body heavier or lighter and longer or shorter, by a factor of its own.

    A body of mass m (1 + e) and size l (1 + f) can exist if the nominal one can, and
    keeps its CM's axis and its principal axes. The uncertainty is the standard
    deviation of e and f; the first robot is nominal.
    """
    if uncertainty == 0.0:
        return [robot]
    random = np.random.default_rng(0)
    e, f = uncertainty * random.standard_normal((2, ROBOTS, len(robot.theta)))
    heavier, longer = np.exp(e), np.exp(f)
    thetas = np.repeat(robot.theta[None], ROBOTS, axis=0)
    thetas[:, :, MASS] *= heavier
    thetas[:, :, FIRST_MOMENT] *= (heavier * longer)[..., None]
    thetas[:, :, INERTIA] *= (heavier * longer**2)[..., None]
    return [robot, *(replace(robot, theta=theta) for theta in thetas)]
