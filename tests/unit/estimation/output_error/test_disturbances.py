"""What acts from outside though nothing may: identified, and not where nothing acts."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from small_problems import (
    NOISE,
    SPIN,
    noisy,
    noisy_in_space,
    small_problem,
    small_recording,
    small_recording_in_space,
    small_robot,
    small_robot_in_space,
)

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.estimate import Estimate
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.problem import (
    NO_ROWS,
    SENSORS,
    Problem,
    changes_factor,
    common_factor,
)
from orbident.estimation.output_error.sensors import at_level
from orbident.estimation.solution import Unknowns
from orbident.estimation.unknowns import DisturbanceFit
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Thruster
from orbident.robot.may_act import may_act
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.flight import JointPD, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse

ARM, DURATION = 0.4, 20.0
"""m, and s."""


def with_sensors(robot: Robot) -> Robot:
    sensors = {
        "gyro": {"angle_random_walk": NOISE["gyro"] / np.sqrt(20)},
        "attitude": {"angle": NOISE["attitude"]},
        "position": {"std": NOISE["position"]},
    }
    return replace(robot, sensors=declared_sensors(sensors))


def identified(recording: Recording) -> dict[str, DisturbanceFit]:
    robot = replace(with_sensors(small_robot()), disturbances={})
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    estimate = OutputError().estimate(problem, lambda _: None)
    assert estimate.converged
    return dict(estimate.disturbances)


def under_a_couple(torque: float) -> Recording:
    """Two thrusters side by side: simulated by the equations of motion (Eq. 13)."""
    robot = small_robot()
    x, y = np.eye(3)[:2]
    sides = (("left", ARM * y, -x), ("right", -ARM * y, x))
    robot = replace(robot, thrusters=tuple(Thruster(*side) for side in sides))
    t = np.arange(round(DURATION * 20) + 1) / 20
    motion = random_motion(robot, 1, DURATION, SPIN, "spun up")
    start = BaseState(
        motion.initial.angular_velocity,
        motion.initial.attitude,
        np.zeros(3),
        np.array([SPIN]),
    )
    command = motion.for_robot(robot)
    law = JointPD(Kp=np.full(1, 50.0), Kd=np.full(1, 50.0))
    force = torque / (2 * ARM)
    pulses = [Pulse(name, 0.0, DURATION, force) for name in ("left", "right")]
    q, _, _ = command.at(t[:1])
    flown = free_flying(robot, t, standing(start, q[0]), command, law, pulses=pulses)
    columns = {
        "joint.joint1.position": flown.q[:, 0],
        "joint.joint1.velocity": flown.qd[:, 0],
        "wheel.rw.speed": flown.qd_rw[:, 0],
    }
    vectors = {
        "gyro": flown.w,
        "attitude": flown.attitude,
        "position": flown.r_S,
        "velocity": flown.v_S,
    }
    for name, values in vectors.items():
        for k, axis in enumerate("xyzw"[: values.shape[1]]):
            columns[f"{name}.{axis}"] = np.ascontiguousarray(values[:, k])
    return Recording(t, columns)


@pytest.mark.parametrize("torque", [1e-4, 2e-3])
def test_a_torque_is_identified(torque):
    """Two thrusters make a couple, on a robot of some kg m^2; nothing else is named."""
    found = identified(noisy(under_a_couple(torque), 0))
    assert set(found) == {"torque.z"}
    group, unit, value, std, shift = found["torque.z"]
    assert (group, unit) == ("torque", "N m")
    assert abs(value - torque) < 4 * std < 0.4 * torque
    # Without it the parameters would be wrong.
    assert shift > 3


@pytest.mark.parametrize("method", ["structured", "least-squares", "recursive"])
def test_every_method_takes_a_torque_into_account(method):
    """The momentum that it gave is that which all sensors show."""
    robot, recording = with_sensors(small_robot()), noisy(under_a_couple(2e-3), 0)
    robot = replace(robot, disturbances={})
    result = identify(robot, recording, method, "at-rest")
    assert result.status == "ok", result.warnings
    assert set(result.disturbances) == {"torque.z"}
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    assert np.abs(off / result.base.std).max() < 4


@pytest.mark.parametrize("size", [1.0, 30.0])
def test_a_pull_is_identified(size):
    """A table that is not level: what falls together moves as it does without gravity,
    and faster by `pull t`. The larger one moves S by a metre."""
    pull = size * np.array([2e-4, -1e-4])
    clean = small_recording(small_robot())
    t, tilted = clean.t, dict(clean.columns)
    for axis, a in zip("xy", pull, strict=True):
        tilted[f"velocity.{axis}"] = tilted[f"velocity.{axis}"] + a * t
        tilted[f"position.{axis}"] = tilted[f"position.{axis}"] + a * t**2 / 2
    found = identified(noisy(Recording(t, tilted), 0))
    assert set(found) == {"pull.x", "pull.y"}
    for axis, a in zip("xy", pull, strict=True):
        fit = found[f"pull.{axis}"]
        assert abs(fit.value - a) < 4 * fit.std


@pytest.mark.parametrize("seed", range(4))
def test_none_is_found_where_there_is_none(seed):
    """One run of ten thousand would show something by chance."""
    assert identified(noisy(small_recording(small_robot()), seed)) == {}


@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_slopes_are_those_of_the_predictions(motion):
    """Slopes by sizes and by `beta` equal differences, everything acting at once."""
    if motion == "planar":
        robot, recording = small_robot(), noisy(small_recording(small_robot()), 0)
    else:
        robot = small_robot_in_space()
        recording = noisy_in_space(small_recording_in_space(robot), 0)
    problem, _, state, _ = small_problem(with_sensors(robot), recording)
    places = np.array([each.place for each in problem.acting.unknowns])
    state = state.selecting(places)
    size = places.size
    common = state.common.copy()
    common[-size:] = 1e-2 * np.linspace(1.0, 2.0, size)
    state = state._replace(common=common)
    # Below those of the sensors are rows of continuity and of encoders.
    sensors = slice(None, -9 - 2 * state.local.shape[1])
    slopes = equations(problem, state, 3)[sensors, -1 - common.size : -1]
    for k in range(9, common.size):
        step = np.zeros(common.size)
        step[k] = 1e-5
        ahead, behind = (
            equations(problem, state._replace(common=common + s * step), 3)
            for s in (1.0, -1.0)
        )
        change = (behind - ahead)[sensors, -1] / 2e-5
        scale = np.abs(change).max()
        np.testing.assert_allclose(slopes[:, k], change, atol=1e-6 * scale)


def equations(problem: Problem, state: Unknowns, interval: int) -> np.ndarray:
    return _core.interval_equations(
        problem.recorded,
        weights=[
            # An attitude's error is a small rotation, linear for small ones only.
            problem.weights.get(name, NO_ROWS) * (name != "attitude")
            for name in SENSORS
        ],
        coloured=at_level(problem.lasting, problem.weights, problem.weights),
        acting=problem.acting.table(state.beta, state.calibration, state.selected),
        **state._asdict(),
        interval=interval,
    )


def asked_for(recording: Recording, *groups: str) -> Estimate:
    robot = replace(with_sensors(small_robot()), disturbances=may_act(groups))
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    return OutputError().estimate(problem, lambda _: None)


def test_what_is_asked_for_is_identified_where_it_is_zero_too():
    recording = noisy(small_recording(small_robot()), 0)
    assert not identified(recording)
    found = asked_for(recording, "pull").disturbances
    assert set(found) == {"pull.x", "pull.y"}
    for fit in found.values():
        assert abs(fit.value) < 4 * fit.std < np.inf


def test_what_is_asked_for_has_the_size_that_a_test_identifies():
    recording = noisy(under_a_couple(1e-4), 0)
    tested, asked = identified(recording), asked_for(recording, "torque").disturbances
    assert set(tested) == set(asked) == {"torque.z"}
    fit = tested["torque.z"]
    assert asked["torque.z"].value == pytest.approx(fit.value, abs=0.02 * fit.std)
    assert asked["torque.z"].std == pytest.approx(fit.std, rel=1e-3)


def test_what_cannot_show_is_refused():
    recording = noisy(small_recording(small_robot()), 0)
    with pytest.raises(InputError, match=r"'air' is asked for.*flow\.x"):
        asked_for(recording, "air")


def test_a_recording_that_is_not_changed_leaves_the_same():
    """With torques, pulls and an error of an instrument that are not zero: what is
    linearised without what acts shows what acts all the same."""
    robot = replace(small_robot_in_space(), disturbances={})
    recording = noisy_in_space(small_recording_in_space(robot), 1)
    problem, _, state, _ = small_problem(robot, recording)
    acting = problem.acting.allowing({"slow_torque": 1e-3, "pull": 1e-3})
    problem = problem._replace(acting=acting)
    scale = problem.unknowns(["gyro.scale.x"])
    places = np.array([each.place for each in (*scale, *problem.expected)])
    sizes = 1e-3 * np.random.default_rng(1).standard_normal(places.size)
    state = state.selecting(places)
    state.common[-places.size :] = sizes
    found = changes_factor(
        problem, problem.weights, state, [(problem, places)], np.ones(1)
    )
    assert places.size > len(scale)
    assert not found[:, -2].any()
    both = np.delete(found, -2, axis=1)
    expected = common_factor(problem, problem.weights, state)
    np.testing.assert_allclose(both.T @ both, expected.T @ expected, rtol=1e-9)


@pytest.mark.parametrize("torque", [0.0, pytest.param(0.02, marks=pytest.mark.slow)])
def test_it_is_asked_later_as_well_as_at_once(torque: float):
    """What acts on a fit of which that was not asked at first."""
    robot = replace(with_sensors(small_robot()), disturbances={})
    recording = noisy(under_a_couple(torque), 1)
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    at_once = OutputError().estimate(problem, lambda _: None)
    first = OutputError(tested=False).estimate(problem, lambda _: None)
    assert first.tested is not None
    assert not first.disturbances
    later = first.tested()
    assert bool(later.unexpected) == bool(torque)
    assert later.unexpected == at_once.unexpected
    values = later.parameters.base.values
    np.testing.assert_array_equal(values, at_once.parameters.base.values)
