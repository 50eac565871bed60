"""The Cramér-Rao bound of a manoeuvre, before anything flies.

No unbiased estimate from these sensors has a smaller covariance than the inverse of the
information that they give, with momenta, biases, attitudes, the joints' histories and
what may act from outside unknown too.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.base_parameters import (
    EstimatedParameters,
    parameters_of_beta,
    prior_std,
)
from orbident.estimation.budget import Budget, budget_of
from orbident.estimation.linear_fits import InitialMomentum, rest_std
from orbident.estimation.output_error.beforehand import prior_of, with_hidden_held
from orbident.estimation.output_error.covariance_parts import (
    covariance_parts,
    estimate_of,
)
from orbident.estimation.output_error.problem import (
    NOTHING,
    Problem,
    linear,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensors import Sensors, sensors_of
from orbident.estimation.output_error.solver import solution_at
from orbident.estimation.solution import Unknowns
from orbident.gaussian import rms_of
from orbident.model.core_robot import wheels_of
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import SENSORS
from orbident.preprocessing.histories import Lead
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rate_noise import RateNoise, least_speed_noise
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.smoothing import smooth
from orbident.preprocessing.wrenches import Wrenches, recorded_wrenches
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.flight import FreeFlying
from orbident.simulation.free_floating import FreeFloating
from orbident.simulation.measure import Truth, measure_truth, truth_of, truth_of_flight
from orbident.simulation.outside import thrust_columns
from orbident.simulation.simulate import float_along, fly_along
from orbident.threads import one_blas_thread
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory


class CramerRao(NamedTuple):
    """What a manoeuvre tells at most."""

    parameters: EstimatedParameters
    """Their nominal values, and the least covariances."""
    budget: Callable[[], Budget]
    """What the least variances are made of."""


@one_blas_thread
def bound_of(
    robot: Robot, trajectory: Trajectory, initial_momentum: InitialMomentum = "unknown"
) -> CramerRao:
    """The bound of `pi`, `phi` and the base parameters, at their nominal values.

    Of the trajectory's environment, the thrusters act, as their recorded force says.
    The momentum is `"at-rest"` where it will be known.

    Raises:
        InputError: the robot file has no noise of a sensor of the base, or the
            trajectory is not for the robot.
    """
    if not any(sensor.white_noise for sensor in robot.sensors.of_base.values()):
        raise InputError(
            f"{robot.name}: sensors: found no noise of gyro, accelerometer, attitude "
            "or position, from which the least deviations are computed; add the noise "
            "of the sensors to the robot file"
        )
    sets = minimal_sets(robot)
    declared = robot.sensors
    motion, true, wrenches = _moved(robot, trajectory, declared.rows_per_second)
    ideal = {name: sensor.ideal() for name, sensor in declared.declared.items()}
    exact = replace(robot, sensors=declared.model_copy(update=ideal))
    recording = measure_truth(exact, motion.t, true).with_joints_of(robot)
    noise = _noise_of_speeds(robot, motion.t)
    sensors = sensors_of(robot, recording, dict.fromkeys(SENSORS, 0.0), noise)
    # Nobody measures passive joints.
    seen = [name not in robot.passive for name in robot.joint_names]
    shown = motion._replace(q=motion.q * seen, qd=motion.qd * seen)
    samples = _true_samples(robot, shown, wrenches, _shares(shown, sensors), noise)
    problem = problem_of(robot, sets, samples, sensors)
    # Where nothing acts they are constant, and else those at the start.
    h_cm, v_cm = (np.atleast_2d(each)[0] for each in (motion.h_cm, motion.v_cm))
    outside = NOTHING._replace(h_cm=h_cm, v_cm=v_cm)
    unknown = (*problem.declared, *problem.expected)
    state = start_of(problem, samples, outside, sets.beta(robot.theta)).carried(
        np.array([each.place for each in unknown])
    )
    if robot.passive:
        state = _swinging(robot, motion, problem, state)
    rest = None
    if initial_momentum == "at-rest":
        h_rw = motion.qd_rw @ wheels_of(robot).A_rw.T
        rest = rest_std(robot, rms_of(h_rw))
    prior = prior_of(robot, sets, problem.declared, outside, rest).extended(
        np.array([each.std for each in problem.expected])
    )
    alone = {"position", "velocity", "accelerometer"}.isdisjoint(sensors.by_name)
    if alone:
        prior = with_hidden_held(prior, robot, sets)
    there = linear(problem, problem.weights, state)
    solution = solution_at(state, there, prior, problem.weights, True, there.cost)
    found = parameters_of_beta(
        robot, sets, estimate_of(solution, prior_std(robot, sets))
    )

    if alone:
        phi, base = (
            each._replace(determined=np.zeros_like(each.determined))
            for each in (found.phi, found.base)
        )
        found = found._replace(phi=phi, base=base)

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


def log_deviation(
    robot: Robot, trajectory: Trajectory, initial_momentum: InitialMomentum = "unknown"
) -> float:
    """The logarithm of the geometric mean of the base parameters' least deviations.

    Such a mean depends on no units. It is infinite where not all parameters are
    determined. Errors are those of `bound_of`.
    """
    base = bound_of(robot, trajectory, initial_momentum).parameters.base
    if not base.determined.all():
        return np.inf
    return float(np.log(np.diag(base.covariance)).mean() / 2)


def _moved(
    robot: Robot, trajectory: Trajectory, rate: float
) -> tuple[FreeFloating | FreeFlying, Truth, Wrenches]:
    """The motion, and what thrusters give meanwhile."""
    thrusters = trajectory.environment.thrusters if trajectory.environment else {}
    if not thrusters and not robot.passive:
        floating = float_along(robot, trajectory, rate)
        return floating, truth_of(robot, floating, trajectory.for_robot(robot)), ()
    exact = {
        name: each.model_copy(update={"gain": 1.0}) for name, each in thrusters.items()
    }
    alone = Environment(thrusters=exact)
    flight = fly_along(robot, replace(trajectory, environment=alone), rate)
    pushes = Recording(flight.t, thrust_columns(alone, flight.t))
    return flight, truth_of_flight(flight), recorded_wrenches(robot, pushes, {})


def _swinging(
    robot: Robot, motion: FreeFloating | FreeFlying, problem: Problem, state: Unknowns
) -> Unknowns:
    """The state with passive joints where they are as intervals meet."""
    rows = np.searchsorted(motion.t, problem.boundaries)
    joints, local = problem.loose.corrected.astype(int), state.local.copy()
    swings = [robot.joint_names[k] in robot.passive for k in joints]
    corrections = [swings * x[rows][:, joints] for x in (motion.q, motion.qd)]
    local[:, -2 * joints.size :] = np.hstack(corrections)
    return state._replace(local=local)


def _shares(motion: FreeFloating | FreeFlying, sensors: Sensors) -> tuple[float, ...]:
    """What smoothing would leave of the encoders' variance."""
    encoders = sensors.by_name.get("joints")
    if encoders is None:
        return motion.q.shape[1] * (np.nan,)
    smoothed = smooth(motion.t, motion.q, encoders.std, name="joints")
    share = np.median(np.square(smoothed.std_x), axis=0) / np.square(encoders.std)
    return tuple(share.tolist())


def _noise_of_speeds(
    robot: Robot, t: Float[np.ndarray, " rows"]
) -> tuple[RateNoise, ...]:
    """That of wheels of which tachometers alone tell; none without such."""
    wheels = robot.sensors.wheels
    if wheels is None or not wheels.tachometer or wheels.white_noise is not None:
        return ()
    shows = least_speed_noise(robot)
    noise = RateNoise.read(wheels.tachometer, t, t.size, shows)
    # These speeds are as smooth as the smoothed ones of a recording.
    noise = noise._replace(white=0.0) if noise.density else noise
    return (noise,) * len(robot.wheels)


def _true_samples(
    robot: Robot,
    motion: FreeFloating | FreeFlying,
    wrenches: Wrenches,
    shares: tuple[float, ...],
    noise: tuple[RateNoise, ...],
) -> Samples:
    return Samples(
        t=motion.t,
        q=tuple(motion.q.T),
        qd=tuple(motion.qd.T),
        w=tuple(motion.w.T),
        x_WB=tuple(motion.attitude.T),
        qd_rw=tuple(motion.qd_rw.T),
        v_S=tuple(motion.v_S.T),
        wrenches=wrenches,
        surroundings={},
        locked=(),
        led={each.follower: Lead(*each[1:]) for each in robot.couplings},
        shares=shares,
        worst=((0.0, 0.0),) * len(shares),
        origins={"wheel_speeds": Origin.MEASURED if noise else Origin(0)},
        speeds=noise,
        source="simulation",
    )
