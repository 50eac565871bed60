"""When thrusters act: against integrals of what is switched, and by differences."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from orbident.environment.motion import PointMotion, RobotMotion, by_step
from orbident.estimation.output_error.acting import integral
from orbident.estimation.output_error.recorded_thrust import (
    RecordedThrust,
    ThrustErrors,
)
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.robot.robot_file import load_robot

T = 0.1 * np.arange(41)
"""s."""


@pytest.fixture(scope="module")
def thrust() -> RecordedThrust:
    """Three thrusters that are switched at random, on a base that does not turn."""
    random, nodes = np.random.default_rng(3), np.union1d(T, (T[:-1] + T[1:]) / 2)
    zero = np.zeros((nodes.size, 3))
    robot = load_robot("cepheus-like")
    joints = np.zeros((nodes.size, len(robot.joints)))
    level = np.tile(np.eye(3), (nodes.size, 1, 1))
    motion = RobotMotion(
        robot, nodes, joints, joints, level, zero, PointMotion(zero, zero)
    )
    wrenches = []
    for k in range(3):
        on = random.integers(0, 2, T.size)[:, None].astype(float)
        force, torque = 2.0 * np.eye(3)[k % 2], np.array([0, 0, 0.3 + k])
        wrenches.append(
            RecordedWrench(f"t{k}", 0.1, on * force, on * torque, 0 * on * force, True)
        )
    return RecordedThrust(motion, T, wrenches)


def switched(thrust: RecordedThrust, errors: ThrustErrors, fine: np.ndarray):
    """The level of each thruster, at any times, by the sentences of the file's head."""
    u = thrust.u
    opened = np.tile(u[0], (fine.size, 1))
    for k in range(1, T.size):
        late = errors.clock + np.where(u[k] < u[k - 1], errors.pulse, 0.0)
        opened += np.where(fine[:, None] >= T[k] + late, u[k] - u[k - 1], 0.0)
    others = np.maximum((opened > 0.5).sum(axis=1, keepdims=True) - 1, 0)
    return (1 + errors.scale) * (1 - errors.coupling * others) * opened


@pytest.mark.parametrize(
    "errors",
    [
        ThrustErrors(),
        ThrustErrors(clock=0.134),
        ThrustErrors(-0.02, 0.03, 0.3, 0.1),
        ThrustErrors(0.31, -0.04, 0.0, -0.2),
    ],
)
def test_velocity_and_place_at_rows(thrust, errors):
    """The lines give to both what the switched levels do, by sums of fine steps."""
    h = 1e-4
    fine = np.arange(round(T[-1] / h)) * h
    level = switched(thrust, errors, fine + h / 2)
    v = np.vstack([np.zeros(3), np.cumsum(level, axis=0) * h])
    x = np.vstack([np.zeros(3), np.cumsum((v[1:] + v[:-1]) / 2, axis=0) * h])
    rows = np.round(T / h).astype(int)
    for k, effect in enumerate(thrust.at(errors)):
        nodes = thrust.motion.t
        found = integral(nodes, effect.force)
        axis = k % 2
        # A switch is seen to within a step: 2 N x 1e-4 s, some twenty times.
        assert_allclose(found[::2, axis], 2 * v[rows, k], atol=3e-3)
        place = integral(nodes, by_step(found))
        assert_allclose(place[::2, axis], 2 * x[rows, k], atol=6e-3)


@pytest.mark.parametrize("errors", [ThrustErrors(), ThrustErrors(0.134, 0.02, 0.3)])
def test_slopes(thrust, errors):
    """Of all thrusters together, by central differences."""
    gains = np.array([0.2, -1.0, 0.1])

    def together(at: ThrustErrors):
        each = zip(1 + gains, thrust.at(at), strict=True)
        total = thrust.motion.nothing
        for gain, effect in each:
            total = total.plus(gain, effect)
        return total

    step = 1e-6
    for name, slope in zip(ThrustErrors._fields, thrust.by(errors, gains), strict=True):
        more, less = (
            together(errors._replace(**{name: getattr(errors, name) + sign * step}))
            for sign in (1, -1)
        )
        for part in ("force", "torque"):
            difference = (getattr(more, part) - getattr(less, part)) / (2 * step)
            # Where a switch is at a row, differences are one-sided by the step.
            assert_allclose(getattr(slope, part), difference, atol=3e-3)
