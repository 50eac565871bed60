"""What errors of instruments cost, beside what the bound says of them by the core."""

from dataclasses import fields, replace

import numpy as np
import pytest

from orbident.excitation.bound import bound_of
from orbident.excitation.design import design_excitation
from orbident.excitation.guarantee import floated
from orbident.excitation.scores import compare_trajectories, scores_of
from orbident.robot.robot_file import load_robot
from orbident.robot.tolerances import CALIBRATION_KINDS, Tolerances
from orbident.studies.spatial import paper_case

WIDE = 5e-3
"""rad, m, s or relative: most kinds then count beside the sensors' noise."""

NOT_HERE = ("joint_frequency", "joint_damping")
"""Of passive joints."""

KINDS = [
    each.name
    for each in fields(Tolerances)
    if each.name not in NOT_HERE and not each.name.startswith("thruster")
]


def off_by(robot, kind):
    """The robot with a tolerance of one kind."""
    of_joints = CALIBRATION_KINDS[kind].name.startswith("joint.")
    std = dict.fromkeys(robot.joint_names, WIDE) if of_joints else WIDE
    return replace(robot, tolerances=replace(Tolerances(), **{kind: std}))


def known(robot, motion):
    momentum = "at-rest" if robot.motion == "planar" else "unknown"
    return bound_of(robot, motion, momentum).parameters


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_has_the_deviations_of_the_bound(emulator, kind):
    robot = off_by(replace(emulator, disturbances=None), kind)
    motion = paper_case(emulator).trajectory
    found = scores_of(robot, [(motion, floated(robot, motion))]).deviations
    bound = known(robot, motion)
    covariances = (
        bound.base.covariance[:1, :1],
        bound.pi.covariance,
        bound.phi.covariance,
    )
    expected = np.sqrt(np.concatenate([np.diag(each) for each in covariances]))
    assert found is not None
    np.testing.assert_allclose(found / expected, 1.0, atol=0.01)


@pytest.mark.parametrize(
    "kind",
    ["wheel_inertia", "joint_zero", "joint_scale", "joint_place", "gyro_scale"],
)
def test_in_space_errors_cost_what_the_bound_says(servicer, table_2, kind):
    """The criterion has no noise of the encoders: so to some percent."""
    robot = off_by(servicer, kind)
    growth = np.sqrt(
        np.diag(known(robot, table_2).base.covariance)
        / np.diag(known(servicer, table_2).base.covariance)
    )
    found = scores_of(robot, [(table_2, floated(robot, table_2))])
    expected = np.exp(np.log(growth).mean())
    assert expected > 1.02
    assert found.price_of_tolerances == pytest.approx(expected, rel=0.05)


@pytest.mark.slow
def test_errors_are_common_to_recordings(emulator):
    """More recordings show parameters ever better, but no more of a wheel's scale."""
    robot, one = off_by(emulator, "wheel_inertia"), paper_case(emulator).trajectory
    found = compare_trajectories(robot, [[one], [one] * 10]).deviations
    exact = compare_trajectories(emulator, [[one], [one] * 10]).deviations
    scale = WIDE * robot.mass
    np.testing.assert_allclose(found[:, 0], np.hypot(exact[:, 0], scale), rtol=1e-3)


@pytest.mark.slow
def test_a_motion_is_designed_for_what_may_be_off():
    """Its value is that of all unknowns; without tolerances another motion is best."""
    robot = load_robot("cepheus-like")
    off = off_by(robot, "feature_point")
    given = replace(paper_case(robot).conditions, basis=None, harmonics=3)
    knows, blind = (
        design_excitation(each, conditions=given, starts=4) for each in (off, robot)
    )
    assert knows.design is not None
    first, second = compare_trajectories(off, [[knows], [blind]]).scores
    assert first.d == pytest.approx(knows.design["value"], rel=1e-9)
    assert (first.d or np.inf) < (second.d or 0.0)
