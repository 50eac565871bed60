"""Where the robot was along a recording, as it was measured, for what acts on it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from orbident.environment.agent import Disturbance
from orbident.environment.agents import PUSH, disturbances
from orbident.environment.motion import PointMotion, RobotMotion, by_step, straight
from orbident.environment.worlds import scale_of, what_may_act
from orbident.errors import InputError
from orbident.estimation.output_error.shooting import Intervals, with_middles
from orbident.files.bounds import TOGETHER
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.robot.description import Robot
from orbident.robot.may_act import MayAct
from orbident.robot.parameters import FIRST_MOMENT, MASS, PER_BODY


@dataclass(frozen=True)
class Followed:
    """The motion at every row, and half-way to the next, worked out as it is asked for.

    It is that measured. A disturbance adds up over time, and its noise does not: where
    drag takes a third of the momentum, deviations still hold.
    """

    robot: Robot
    sets: MinimalSets
    samples: Samples
    intervals: Intervals
    """With the rows."""

    @cached_property
    def t(self) -> Float[np.ndarray, " nodes"]:
        """Times of the nodes, s."""
        return with_middles(self.intervals.t)

    @cached_property
    def wrenches(self) -> tuple[RecordedWrench, ...]:
        """What is known to act on the base from a row until the next."""
        t = self.intervals.t
        last = np.searchsorted(self.samples.t, t + TOGETHER, side="right") - 1
        before = np.maximum(last, 0)
        return tuple(
            wrench._replace(
                force=wrench.force[before],
                torque=wrench.torque[before],
                dipole=wrench.dipole[before],
            )
            for wrench in self.samples.wrenches
        )

    @property
    def tracked(self) -> bool:
        """Whether the velocity of S is known."""
        return bool(self.samples.v_S)

    @cached_property
    def motion(self) -> RobotMotion:
        """All of it; in inertial axes the surroundings change slowly."""
        samples, history, t = self.samples, self.intervals.history, self.t
        w = self._between(samples.w)
        x = np.column_stack(samples.x_WB)
        known = np.isfinite(x).all(axis=1)
        at, x_WB = samples.t[known], Rotation.from_quat(x[known])
        S = None
        if self.tracked:
            v_S = self._between(samples.v_S)
            S = PointMotion(integral(t, by_step(v_S)), v_S)
        return RobotMotion(
            self.robot,
            t,
            history.at(history.q, history.q_slope, t),
            history.at(history.qd, history.qdd, t),
            Slerp(at, x_WB)(np.clip(t, at[0], at[-1])).as_matrix(),
            w,
            S,
            {
                name: straight(t, at, x_WB.apply(seen[known]))
                for name, seen in samples.surroundings.items()
            },
            samples.pushed,
            self.allowed,
        )

    @cached_property
    def disturbances(self) -> tuple[Disturbance, ...]:
        """All that may act beside what was recorded, and shows."""
        return tuple(disturbances(self.motion))

    @cached_property
    def allowed(self) -> dict[str, MayAct]:
        """What may act, by how large the motion is where all was measured."""
        samples, history = self.samples, self.intervals.history
        w = np.column_stack(samples.w)
        v_S = np.column_stack(samples.v_S) if self.tracked else None
        scale = scale_of(
            self.robot,
            self.intervals.t,
            np.reshape(history.qd_rw, (len(self.robot.wheels), history.t.size)).T,
            w[np.isfinite(w).all(axis=1)],
            v_S if v_S is None else v_S[np.isfinite(v_S).all(axis=1)],
        )
        allowed = what_may_act(self.robot, scale)
        return allowed | {PUSH: MayAct(np.inf)} if samples.pushed else allowed

    def _between(self, columns: Columns) -> Float[np.ndarray, "nodes axes"]:
        x = np.column_stack(columns)
        known = np.isfinite(x).all(axis=1)
        if known.sum() < 2:
            raise InputError(
                f"{self.samples.source}: joints, wheels and base are known together "
                f"at {known.sum()} times, and 2 are needed at least; check the clocks, "
                "or record longer"
            )
        return np.asarray(CubicSpline(self.samples.t[known], x[known])(self.t))

    @cached_property
    def moments(self) -> Float[np.ndarray, "nodes 3 beta"]:
        """The first moment about S by each `beta`; inertial axes, kg m by its unit."""
        at = self.motion.poses
        n, bodies = at.d.shape[:2]
        by_theta = np.zeros((n, 3, PER_BODY * bodies))
        for i in range(bodies):
            own = np.zeros((n, 3, PER_BODY))
            own[:, :, MASS] = at.d[:, i]
            own[:, :, FIRST_MOMENT] = at.R[:, i]
            by_theta[:, :, PER_BODY * i : PER_BODY * (i + 1)] = own
        return self.motion.R_WB @ (by_theta @ self.sets.base.theta_of)


def at_nodes(x: Float[np.ndarray, "steps 3 ..."]) -> Float[np.ndarray, "nodes ..."]:
    """What holds from each node on."""
    out = np.empty((2 * len(x) + 1, *x.shape[2:]))
    out[:-1:2], out[1::2], out[-1] = x[:, 0], x[:, 1], x[-1, 2]
    return out


def integral(
    t: Float[np.ndarray, " nodes"], x: Float[np.ndarray, "steps 3 ..."]
) -> Float[np.ndarray, "nodes ..."]:
    """The integral from the first node on, by parabolas through each step's nodes."""
    h = np.diff(t[::2]).reshape(-1, *(1,) * (x.ndim - 2))
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    out = np.zeros((t.size, *x.shape[2:]))
    out[2::2] = np.cumsum(h * (a + 4 * b + c) / 6, axis=0)
    out[1::2] = out[:-1:2] + h * (5 * a + 8 * b - c) / 24
    return out
