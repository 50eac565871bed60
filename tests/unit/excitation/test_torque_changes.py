"""Torques at joints in the criterion: inverse dynamics, the bound, and a design."""

from dataclasses import replace

import numpy as np
import pytest
from design_gradients import check_gradient
from random_motions import random_motion
from random_robots import random_robot

from orbident.excitation.bound import bound_of
from orbident.excitation.conditions import conditions_for
from orbident.excitation.design import design_excitation
from orbident.excitation.design_problem import problem_for
from orbident.excitation.floating import craft_of
from orbident.excitation.guarantee import floated
from orbident.excitation.information import SensedChanges, sensing_of
from orbident.excitation.scores import compare_trajectories, scores_of
from orbident.excitation.torque_changes import NODES
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Coupling, Friction
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import Tolerances
from orbident.simulation.simulate import made_along

SENSORS = {
    "rate": 20.0,
    "gyro": {"angle_random_walk": 3e-6, "bias_instability": 1e-6},
    "attitude": {"angle": 2e-4},
    "position": {"std": 1e-4},
}

TORQUES = {"torques": {"std": 0.05}}

RUBS = Friction(0.5, 0.2, 0.1)
"""N m s, N m and N m, or the same of a joint that slides."""


def of_every(robot, value):
    return dict.fromkeys(robot.joint_names, value)


def with_torques(robot, **tolerances):
    """A robot without wheels, whose torque sensors give the scale; friction is free."""
    free = of_every(robot, np.inf)
    return replace(
        robot,
        wheels=(),
        disturbances={},
        sensors=declared_sensors({**SENSORS, **TORQUES}),
        friction=of_every(robot, RUBS),
        tolerances=Tolerances(
            joint_viscous=free,
            joint_coulomb=free,
            joint_torque_offset=free,
            **tolerances,
        ),
    )


@pytest.mark.parametrize("seed", range(2))
def test_parameters_change_torques_as_inverse_dynamics_say(seed):
    """At rest as a whole: what attitude it has makes no difference to the momentum."""
    robot = with_torques(random_robot(seed, (0, 1, 0), (1,) if seed % 2 else ()))
    trajectory = random_motion(robot, seed, 20.0, start="spun up").for_robot(robot)
    rate, sets = 80.0, minimal_sets(robot)
    sensing = sensing_of(robot, sets)
    craft = craft_of(robot, sets, trajectory.initial, trajectory.start, True)
    made = made_along(robot, trajectory, rate)
    seen = craft.seen(
        made.true.q, made.true.qd, made.true.gyro, made.true.attitude, 1 / rate
    )
    found = SensedChanges(sensing, seen, at_rest=True).rows("torques")

    def torques(direction, step):
        theta = robot.theta + step * direction.reshape(robot.theta.shape)
        tau = made_along(replace(robot, theta=theta), trajectory, rate).true.tau
        assert tau is not None
        return tau

    step = 1e-4
    for k, direction in enumerate((sets.base.theta_of @ sensing.beta_of).T):
        small = step / np.abs(direction).max()
        change = torques(direction, small) - torques(direction, -small)
        expected = change / (2 * small)
        ends = range(0, len(expected) - NODES, NODES)
        means = [np.trapezoid(expected[i : i + NODES + 1], axis=0) for i in ends]
        # Steps of 0.05 s of motions of some rad/s: the trapezoidal rule over `e`.
        np.testing.assert_allclose(
            found[:, :, k],
            np.array(means) / NODES,
            atol=2e-3 * np.abs(expected).max(),
        )


@pytest.mark.parametrize(
    "kind",
    [
        *("", "joint_torque_scale", "joint_armature"),
        *("joint_zero", "joint_scale", "joint_place", "joint_direction"),
        "joint_clock",
    ],
)
def test_deviations_are_those_of_the_bound(servicer, kind):
    """The bound has them by the estimate's own equations."""
    std = np.inf if kind == "joint_armature" else 5e-3
    own = {kind: std if kind == "joint_clock" else of_every(servicer, std)}
    robot = with_torques(servicer, **(own if kind else {}))
    # The criterion has no noise of encoders.
    sensors = {**SENSORS, **TORQUES, "joints": {"position": 1e-8}}
    robot = replace(robot, sensors=declared_sensors(sensors))
    motion = random_motion(robot, 1, 60.0, start="turning")
    found = scores_of(robot, [(motion, floated(robot, motion))])
    bound = bound_of(robot, motion).parameters
    known = bound.base.covariance[:1, :1], bound.pi.covariance, bound.phi.covariance
    expected = np.sqrt(np.concatenate([np.diag(each) for each in known]))
    assert found.deviations is not None
    ratio = found.deviations / expected
    # Intervals of the bound lose what changes inside them, and some reversals.
    assert float(np.exp(np.log(ratio).mean())) == pytest.approx(1.0, abs=0.02)
    assert ratio == pytest.approx(np.ones(ratio.size), abs=0.25)


@pytest.mark.parametrize(
    "name", [pytest.param("servicer", marks=pytest.mark.slow), "emulator"]
)
def test_the_gradient_by_differences(request, name):
    known = request.getfixturevalue(name)
    kinds = "torque_scale", "zero", "scale", "place", "direction"
    errors = {f"joint_{kind}": of_every(known, 1e-3) for kind in kinds}
    armature = of_every(known, np.inf)
    robot = with_torques(known, joint_armature=armature, joint_clock=1e-3, **errors)
    robot = replace(robot, wheels=known.wheels)
    problem = problem_for(robot, conditions_for(robot, 20.0, 2), "d", 0.0)
    check_gradient(problem, 1e-4, 1e-4)


def test_joints_that_others_move_have_no_torques(servicer):
    follows = Coupling("joint3", "joint2", 0.5, 0.0)
    robot = with_torques(replace(servicer, couplings=(follows,)))
    sensing = sensing_of(robot, minimal_sets(robot))
    assert sensing.driven == (0,)
    still = replace(robot, couplings=(follows, Coupling("joint1", "joint2", 1.0, 0.0)))
    assert "torques" not in sensing_of(still, minimal_sets(still)).weights


@pytest.mark.slow
def test_a_motion_is_designed_for_torques():
    """Without a wheel, momentum alone gives no scale, and so no deviations."""
    robot = with_torques(load_robot("paper-spatial"))
    blind = replace(robot, sensors=declared_sensors(SENSORS))
    given = conditions_for(robot, 40.0)
    knows = design_excitation(robot, conditions=given, starts=2)
    other = design_excitation(blind, conditions=given, starts=2, objective="cond")
    first, second = compare_trajectories(robot, [[knows], [other]]).scores
    assert knows.design is not None
    assert first.d == pytest.approx(knows.design["value"], rel=1e-9)
    assert (first.d or np.inf) < (second.d or 0.0)
