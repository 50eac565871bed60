"""The Cramér-Rao bound of a manoeuvre, before anything flies.

No unbiased estimate from these sensors has a smaller covariance than the inverse of the
information that they give, with momenta, biases, attitudes, the joints' histories and
what may act from outside unknown too.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.errors import InputError
from orbident.estimation.base_parameters import (
    EstimatedParameters,
    parameters_of_beta,
    prior_std,
)
from orbident.estimation.budget import Budget, budget_of
from orbident.estimation.linear_fits import InitialMomentum, rest_std
from orbident.estimation.output_error.beforehand import prior_of
from orbident.estimation.output_error.covariance_parts import covariance_parts
from orbident.estimation.output_error.estimator import estimate_of
from orbident.estimation.output_error.problem import (
    NOTHING,
    linear,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensors import Sensors, sensors_of
from orbident.estimation.output_error.solver import solution_at
from orbident.model.core_robot import wheels_of
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import SENSORS
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.smoothing import smooth
from orbident.robot.description import Robot
from orbident.robot.passive_joints import require_measured
from orbident.simulation.free_floating import FreeFloating
from orbident.simulation.measure import measure
from orbident.simulation.simulate import float_along
from orbident.threads import one_blas_thread
from orbident.trajectories.trajectory import Trajectory


class CramerRao(NamedTuple):
    """What a manoeuvre tells at most."""

    parameters: EstimatedParameters
    """Their nominal values, and the least covariances."""
    budget: Callable[[], Budget]
    """What the least variances are made of."""


@one_blas_thread
def bound_of(
    robot: Robot,
    trajectory: Trajectory,
    initial_momentum: InitialMomentum = "unknown",
) -> CramerRao:
    """The bound of `pi`, `phi` and the base parameters, at their nominal values.

    Args:
        robot: with the noise of its sensors.
        trajectory: of the joints, with the initial state of base and wheels.
        initial_momentum: `"at-rest"` where the momentum will be known.

    Raises:
        InputError: the robot file has no noise of a sensor of the base, or the
            trajectory is not for the robot.
    """
    require_measured(robot, "the bound of a motion")
    _check_noise(robot)
    sets = minimal_sets(robot)
    declared = robot.sensors
    motion = float_along(robot, trajectory, declared.rows_per_second)
    ideal = {name: sensor.ideal() for name, sensor in declared.declared.items()}
    exact = replace(robot, sensors=declared.model_copy(update=ideal))
    recording = measure(exact, motion, trajectory)
    sensors = sensors_of(robot, recording, dict.fromkeys(SENSORS, 0.0))
    samples = _true_samples(motion, _shares(motion, sensors))
    problem = problem_of(robot, sets, samples, sensors)
    outside = NOTHING._replace(h_cm=motion.h_cm, v_cm=motion.v_cm)
    unknown = (*problem.declared, *problem.expected)
    state = start_of(problem, samples, outside, sets.beta(robot.theta)).carried(
        np.array([each.place for each in unknown])
    )
    rest = None
    if initial_momentum == "at-rest":
        h_rw = motion.qd_rw @ wheels_of(robot).A_rw.T
        rest = rest_std(robot, float(np.sqrt(np.mean(np.sum(h_rw**2, axis=1)))))
    prior = prior_of(robot, sets, problem.declared, outside, rest).extended(
        np.array([each.std for each in problem.expected])
    )
    there = linear(problem, problem.weights, state)
    solution = solution_at(state, there, prior, problem.weights, True, there.cost)
    found = parameters_of_beta(
        robot, sets, estimate_of(solution, prior_std(robot, sets))
    )

    def budget() -> Budget:
        words, known = formulas_of(robot, sets), (found.base, found.phi, found.pi)
        return budget_of(
            covariance_parts(problem, solution),
            (*words.base.names, *words.phi.names, *words.pi.names),
            robot,
            sets,
            state.beta,
            np.concatenate([each.determined for each in known]),
        )

    return CramerRao(found, budget)


def _check_noise(robot: Robot) -> None:
    if not any(sensor.white_noise for sensor in robot.sensors.of_base.values()):
        raise InputError(
            f"{robot.name}: sensors: found no noise of gyro, accelerometer, attitude "
            "or position, from which the least deviations are computed; add the noise "
            "of the sensors to the robot file"
        )


def _shares(motion: FreeFloating, sensors: Sensors) -> tuple[float, ...]:
    """What smoothing would leave of the encoders' variance."""
    encoders = sensors.by_name.get("joints")
    if encoders is None:
        return motion.q.shape[1] * (np.nan,)
    smoothed = smooth(motion.t, motion.q, encoders.std, name="joints")
    share = np.median(np.square(smoothed.std_x), axis=0) / np.square(encoders.std)
    return tuple(share.tolist())


def _true_samples(motion: FreeFloating, shares: tuple[float, ...]) -> Samples:
    return Samples(
        t=motion.t,
        q=tuple(motion.q.T),
        qd=tuple(motion.qd.T),
        w=tuple(motion.w.T),
        x_WB=tuple(motion.attitude.T),
        qd_rw=tuple(motion.qd_rw.T),
        v_S=tuple(motion.v_S.T),
        wrenches=(),
        surroundings={},
        locked=(),
        shares=shares,
        origins={"wheel_speeds": Origin(0)},
        source="simulation",
    )
