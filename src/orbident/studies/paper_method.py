"""The paper's method: linear fits of signals that were filtered beforehand."""

import time
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.base_parameters import EstimatedParameters
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.obstacles import no_velocity, obstacles
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.estimation.triangular import condition_numbers
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.integrals import integrate_gyro, velocity_from_accelerometer
from orbident.preprocessing.low_pass import CutOff, choose_cut_off, low_pass
from orbident.preprocessing.rates import spline_rates
from orbident.recordings.columns import vector_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies import paper_tables
from orbident.studies.paper_tables import Columns, PaperBasis, paper_basis
from orbident.trajectories.trajectory import InitialState

Signals = dict[str, Float[np.ndarray, " n"]]


@dataclass(frozen=True)
class Filters:
    """Butterworth filters, each with the cut-off of the first samples it saw.

    As the paper does it (Section 5.3), whose cut-offs were chosen once from FFTs.
    """

    cut_offs: dict[str, CutOff] = field(default_factory=dict)
    """Cut-offs of the filters, by signal."""

    def smooth(
        self, t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], name: str
    ) -> Float[np.ndarray, " n"]:
        """Samples without their noise.

        Times are evenly spaced, s; samples are in any unit, without gaps.

        Raises:
            InputError: there are gaps, or the samples are not evenly spaced.
        """
        if name not in self.cut_offs:
            self.cut_offs[name] = choose_cut_off(t, x, name=name)
        return low_pass(t, x[:, None], self.cut_offs[name].frequency, name=name)[:, 0]

    def with_rate(
        self, t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], name: str
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Filtered, and its rate: differentiated, and filtered again.

        With the position's cut-off both times: noise is white, and so told from the
        signal, only before it is differentiated.
        """
        smooth = self.smooth(t, x, name)
        return smooth, self.smooth(t, spline_rates(t, smooth), name)

    def joints_and_wheels(self, robot: Robot, recording: Recording) -> Signals:
        """Positions and rates of joints, and speeds of wheels, from their encoders.

        Raises:
            InputError: a column is missing or has gaps, or the samples are not evenly
                spaced.
        """
        t, columns = recording.t, {}
        for name in robot.joint_names:
            position = f"joint.{name}.position"
            q, qd = self.with_rate(t, recording.column(position), position)
            columns |= {position: q, f"joint.{name}.velocity": qd}
        for name in robot.wheel_names:
            angle = f"wheel.{name}.position"
            _, speed = self.with_rate(t, recording.column(angle), angle)
            columns[f"wheel.{name}.speed"] = speed
        return columns


def from_imu(
    robot: Robot, recording: Recording, initial: InitialState, filters: Filters
) -> Recording:
    """Encoders differentiated; attitude and velocity of S by integration.

    Recorded are joint and wheel positions, gyro and accelerometer, evenly sampled; the
    initial state has attitude of the base and velocity of S at the first sample.

    Raises:
        InputError: a column is missing or has gaps, or the samples are not evenly
            spaced.
    """
    t = recording.t
    gyro = vector_columns("gyro")
    w = [filters.smooth(t, recording.column(name), name) for name in gyro]
    x_WB = integrate_gyro(t, np.column_stack(w), initial.attitude)
    felt = velocity_from_accelerometer(t, x_WB, recording.vector("accelerometer"))
    columns = filters.joints_and_wheels(robot, recording)
    columns |= dict(zip(gyro, w, strict=True))
    columns |= zip(vector_columns("attitude"), x_WB.T, strict=True)
    v_S = initial.velocity + felt
    columns |= zip(vector_columns("velocity"), v_S.T, strict=True)
    return Recording(t, columns, source=recording.source)


def from_mocap(robot: Robot, recording: Recording, filters: Filters) -> Recording:
    """Rates of everything by differentiation, in the plane.

    The paper filters what motion capture gives only after it is differentiated. The two
    may change places but for the ends of the record. Recorded are joint and wheel
    positions, attitude and position, evenly sampled.

    Raises:
        InputError: a column is missing or has gaps, or the samples are not evenly
            spaced.
    """
    t = recording.t
    turned = yaw_of(recording.vector("attitude", "xyzw"))
    yaw, rate = filters.with_rate(t, turned, "attitude")
    _, v_x = filters.with_rate(t, recording.column("position.x"), "position.x")
    _, v_y = filters.with_rate(t, recording.column("position.y"), "position.y")
    nothing = np.zeros(t.size)
    columns = filters.joints_and_wheels(robot, recording)
    columns |= {"gyro.x": nothing, "gyro.y": nothing, "gyro.z": rate}
    columns |= {"attitude.x": nothing, "attitude.y": nothing}
    columns |= {"attitude.z": np.sin(yaw / 2), "attitude.w": np.cos(yaw / 2)}
    columns |= {"velocity.x": v_x, "velocity.y": v_y, "velocity.z": nothing}
    return Recording(t, columns, source=recording.source)


def yaw_of(x_WB: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, " n"]:
    """How far the base has turned about z, over full turns, rad.

    Unit quaternions are about z, of either sign, scalar last.
    """
    # Twice the half angle, which a quaternion and its negative see pi apart.
    return 2 * np.unwrap(np.arctan2(x_WB[:, 2], x_WB[:, 3]), period=np.pi)


def paper_method(
    robot: Robot, recording: Recording, initial_momentum: InitialMomentum
) -> Result:
    """Identify by Eqs. 24, 31 and 32 alone.

    Filtered signals are no sensor's any more, so the result is not judged by what
    sensors show: a study knows the truth.
    """
    started = time.perf_counter()
    solved = paper_fits(robot, recording, initial_momentum)
    return judged(solved, LeastSquares.name, time.perf_counter() - started)


def paper_fits(
    robot: Robot, recording: Recording, initial_momentum: InitialMomentum
) -> Solved:
    """The linear fits of `paper_method`, before they are judged."""
    problem = momentum_problem(robot, recording, initial_momentum, lambda _: None)
    estimate = LeastSquares().estimate(problem, lambda _: None)
    return Solved(problem, [*obstacles(problem), *no_velocity(problem)], estimate, None)


def judged(solved: Solved, method: str, elapsed: float = 0.0) -> Result:
    """The result of an estimate by a method, which took the elapsed time, s."""
    masses = dict(solved.estimate.masses)
    judgement = judge(solved, masses)
    return result_of(
        solved.problem, method, solved.estimate, judgement, masses, None, elapsed
    )


STRETCH = 1.0
"""s before and after the burn over which a slope is taken."""


def mass_by_slopes(burn: Recording) -> float:
    """`M = F dt / (v_2 - v_1)` along y (Eq. 40), kg.

    The burn is that of Section 5.5, with the attitude held; the position of S is in m.
    """
    t, y = burn.t, burn.column("position.y")
    on, off = paper_tables.BURN_START, paper_tables.BURN_START + paper_tables.BURN_LASTS
    before = (t >= on - STRETCH) & (t <= on)
    after = (t >= off) & (t <= off + STRETCH)
    v_1, v_2 = (float(np.polyfit(t[part], y[part], 1)[0]) for part in (before, after))
    return paper_tables.BURN_FORCE[1] * paper_tables.BURN_LASTS / (v_2 - v_1)


class PaperParameters(NamedTuple):
    """The parameters of a table of the paper, M last, as results have them."""

    basis: PaperBasis
    true: Float[np.ndarray, " parameters"]
    """What they are of the robot's nominal inertia."""

    @classmethod
    def of(cls, robot: Robot, columns: Columns) -> "PaperParameters":
        """The table whose regressors have these columns."""
        sets = minimal_sets(robot)
        basis = paper_basis(sets, columns)
        pi, phi = basis.pi(sets.pi(robot.theta)), basis.phi(sets.phi(robot.theta))
        return cls(basis, np.concatenate([pi, phi, [robot.mass]]))

    def found(self, result: Result) -> Float[np.ndarray, " parameters"]:
        """The result's; M is that of Eq. 32."""
        pi, phi = self.basis.pi(result.pi.values), self.basis.phi(result.phi.values)
        return np.concatenate([pi, phi, [result.mass.value]])

    def std(self, found: EstimatedParameters) -> Float[np.ndarray, " all_but_M"]:
        """Deviations of all but M, as those of the minimal sets make them."""
        sets = (self.basis.pi_of_pi, found.pi), (self.basis.phi_of_phi, found.phi)
        std = [np.sqrt(np.diag(J @ each.covariance @ J.T)) for J, each in sets]
        return np.concatenate(std)

    def errors(
        self, found: Float[np.ndarray, " parameters"]
    ) -> Float[np.ndarray, " parameters"]:
        """Percent, signed."""
        return 100 * (found / self.true - 1)


def condition_in_basis(basis: PaperBasis, result: Result) -> dict[str, float]:
    """Condition numbers of a result's regressors, in the paper's parameters."""
    assert result.fits is not None
    pi, phi = result.fits.pi.factor, result.fits.phi.factor
    Y = condition_numbers(pi @ np.linalg.inv(basis.pi_of_pi))
    W = condition_numbers(phi @ np.linalg.inv(basis.phi_of_phi))
    names = ("Y", "Y_normalised", "W", "W_normalised")
    return dict(zip(names, (*Y, *W), strict=True))
