"""Torque and pull from outside, of known size: found; and not found where none is."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from small_problems import (
    NOISE,
    SPIN,
    noisy,
    small_problem,
    small_recording,
    small_robot,
)

from orbident.estimation import maximum_likelihood
from orbident.estimation.output_error import estimator
from orbident.estimation.output_error.disturbances import (
    Push,
    freed,
    place_of,
    push_of,
)
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.solver import Solution, solved
from orbident.estimation.problem import momentum_problems
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Thruster
from orbident.simulation.control_laws import JointPD
from orbident.simulation.flight import standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.thrusters import Pulse

ARM, DURATION = 0.4, 20.0
"""m, and s."""


def with_sensors() -> Robot:
    sensors = {
        "gyro": {"angle_random_walk": NOISE["gyro"] / np.sqrt(20)},
        "attitude": {"angle": NOISE["attitude"]},
        "position": {"std": NOISE["position"]},
    }
    return replace(small_robot(), sensors=sensors)


def solution_of(recording: Recording, *free: str) -> Solution:
    """With these pushes unknown from the start; noise as it is."""
    problem, prior, state, _ = small_problem(with_sensors(), recording)
    for name in free:
        prior = freed(prior, name)
    solution = solved(problem, problem.weights, prior, state)
    assert solution.converged
    return solution


def torque_of(solution: Solution) -> Push:
    return push_of(solution, "torque", (2,))


def pull_of(solution: Solution) -> Push:
    return push_of(solution, "pull", (0, 1))


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


def test_a_torque_is_found():
    """Of two thrusters that make a couple; 2 mN m on a robot of some kg m^2."""
    torque = 2e-3
    recording = noisy(under_a_couple(torque), 0)
    # To first order from a solution that knows of no torque.
    found = torque_of(solution_of(recording))
    assert found.believed
    assert found.value[0] == pytest.approx(torque, rel=0.1)
    solution = solution_of(recording, "torque")
    found = torque_of(solution)
    assert found.believed
    assert abs(found.value[0] - torque) < 5 * found.std[0]
    assert found.std[0] < torque / 5
    # With the torque known to be there, nothing is left that looks like a pull.
    assert not pull_of(solution).believed


def test_a_torque_is_reported_as_it_was_estimated(monkeypatch):
    """Not as it looked before the fit knew of it."""
    fits, likelihoods = [], []

    def keep(module, name, into):
        original = getattr(module, name)

        def kept(*args):
            into.append(original(*args))
            return into[-1]

        monkeypatch.setattr(module, name, kept)

    keep(maximum_likelihood, "fitted", fits)
    keep(estimator, "maximum_likelihood", likelihoods)
    recording = noisy(under_a_couple(1e-4), 0)
    robot = with_sensors()
    problem, *_ = momentum_problems(robot, recording, "at-rest", lambda _: None)
    OutputError().estimate(problem, lambda _: None)
    *_, last = (fit.solution for fit in fits)
    place = last.linear.local + place_of("torque").start + 2
    torque = likelihoods[0].pushes["torque"]
    std = np.sqrt(last.covariance[place, place])
    np.testing.assert_allclose(torque.std[0], std, rtol=1e-6)
    assert abs(torque.value[0] - last.state.common[place - last.linear.local]) < std


def test_a_pull_is_found():
    """A table that is not level: what falls together moves as it does without gravity,
    and faster by `pull t`."""
    pull = np.array([2e-4, -1e-4])
    clean = small_recording(small_robot())
    t, tilted = clean.t, dict(clean.columns)
    for axis, a in zip("xy", pull, strict=True):
        tilted[f"velocity.{axis}"] = tilted[f"velocity.{axis}"] + a * t
        tilted[f"position.{axis}"] = tilted[f"position.{axis}"] + a * t**2 / 2
    solution = solution_of(noisy(Recording(t, tilted), 0))
    found = pull_of(solution)
    assert found.believed
    assert (np.abs(found.value - pull) < 5 * found.std).all()
    assert not torque_of(solution).believed


@pytest.mark.parametrize("seed", range(8))
def test_none_is_found_where_there_is_none(seed):
    """By chance in one run of ten thousand."""
    solution = solution_of(noisy(small_recording(small_robot()), seed))
    for push in (torque_of(solution), pull_of(solution)):
        assert not push.believed
        assert (np.abs(push.value) < 5 * push.std).all()
