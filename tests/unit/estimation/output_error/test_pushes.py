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

from orbident.dynamics.control_laws import ComputedTorque
from orbident.dynamics.equations_of_motion import model_of
from orbident.dynamics.flight import standing
from orbident.dynamics.free_floating import BaseState
from orbident.dynamics.free_flying import free_flying
from orbident.dynamics.thrusters import Pulse
from orbident.estimation.output_error.pushes import Push, push_of
from orbident.estimation.output_error.solve import solved
from orbident.recordings.recording import Recording
from orbident.robot.description import Thruster

ARM, DURATION = 0.4, 20.0
"""m, and s."""


def pushes(recording: Recording) -> dict[str, Push]:
    """As found by the recording's solution; noise as it is."""
    robot = small_robot()
    sensors = {
        "gyro": {"angle_random_walk": NOISE["gyro"] / np.sqrt(20)},
        "attitude": {"angle": NOISE["attitude"]},
        "position": {"std": NOISE["position"]},
    }
    robot = replace(robot, sensors=sensors)
    problem, prior, state, _ = small_problem(robot, recording)
    solution = solved(problem, prior, state)
    assert solution.converged
    return {
        "torque": push_of(solution, "torque", (2,)),
        "pull": push_of(solution, "pull", (0, 1)),
    }


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
    law = ComputedTorque(model_of(robot), kp=np.full(1, 4.0), kd=np.full(1, 4.0))
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
    found = pushes(noisy(under_a_couple(torque), 0))
    assert found["torque"].believed
    assert not found["pull"].believed
    assert abs(found["torque"].value[0] - torque) < 5 * found["torque"].std[0]
    assert found["torque"].std[0] < torque / 5


def test_a_pull_is_found():
    """A table that is not level: what falls together moves as it does without gravity,
    and faster by `pull t`."""
    pull = np.array([2e-4, -1e-4])
    clean = small_recording(small_robot())
    t, tilted = clean.t, dict(clean.columns)
    for axis, a in zip("xy", pull, strict=True):
        tilted[f"velocity.{axis}"] = tilted[f"velocity.{axis}"] + a * t
        tilted[f"position.{axis}"] = tilted[f"position.{axis}"] + a * t**2 / 2
    found = pushes(noisy(Recording(t, tilted), 0))
    assert found["pull"].believed
    assert not found["torque"].believed
    error = np.abs(found["pull"].value - pull)
    assert (error < 5 * found["pull"].std).all()


@pytest.mark.parametrize("seed", range(8))
def test_none_is_found_where_there_is_none(seed):
    """By chance in one run of ten thousand."""
    found = pushes(noisy(small_recording(small_robot()), seed))
    for push in found.values():
        assert not push.believed
        assert (np.abs(push.value) < 5 * push.std).all()
