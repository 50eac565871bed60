"""Motions that excite a robot whose panels swing, and what is promised of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from swinging_satellite import ARM, swinging_satellite

import orbident as oi
from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.excitation.bound import bound_of
from orbident.excitation.conditions import Conditions, conditions_for, limits_of
from orbident.excitation.design import design_excitation, design_recordings
from orbident.excitation.floating import usual_initial
from orbident.excitation.search import Effort
from orbident.excitation.swinging import design_swinging, stiff
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import Trajectory


def geometric_mean(robot: Robot, motion: Trajectory) -> float:
    covariance = bound_of(robot, motion, "at-rest").parameters.base.covariance
    return float(np.exp(np.log(np.sqrt(np.diag(covariance))).mean()))


@pytest.mark.long
def test_the_best_of_several_numbers_of_harmonics_is_kept(tmp_path: Path):
    """What is promised is what the bound says, and a simulation keeps to the limits."""
    robot = swinging_satellite(tmp_path)
    limits = limits_of(robot, base_rate=0.35)
    given = conditions_for(robot, 20.0, limits=limits)
    slow = usual_initial(robot, given.start, 5.0, at_rest=True)
    given = replace(given, initial=slow)
    effort = Effort(1, None)
    motion = design_swinging(robot, given, effort, (3, 10), design_excitation)
    made = motion.design
    assert motion.joints == ARM
    assert made is not None
    tried = {each["harmonics"]: each["value"] for each in made["by_harmonics"]}
    assert set(tried) == {3, 10}
    assert made["value"] == min(tried.values()) == tried[made["harmonics"]]
    assert made["value"] == pytest.approx(geometric_mean(robot, motion), rel=1e-6)
    # Ten of them ring the panels, which are at 0.4 Hz, and three do not.
    assert made["harmonics"] == 10
    flown = oi.simulate(robot, motion)
    w = np.column_stack([flown.columns[f"gyro.{axis}"] for axis in "xyz"])
    rate = np.linalg.norm(w, axis=1).max()
    assert rate == pytest.approx(made["extremes"]["rate"], rel=1e-3)
    assert rate < 0.35
    assert made["amplitude_kept"] <= 1
    assert 0 < made["extremes"]["swings"]["panel_left"] < 0.5


@pytest.mark.slow
def test_a_robot_that_was_at_rest_is_not_doubted(tmp_path: Path):
    """The linear equations, in which nothing swings, do not fit from rest."""
    robot = swinging_satellite(tmp_path)
    given = conditions_for(robot, 20.0, harmonics=3)
    at_rest = usual_initial(robot, given.start, 60.0, at_rest=True)
    given = replace(given, initial=at_rest)
    motion = design_excitation(robot, starts=1, conditions=given)
    flown = oi.simulate(robot, motion, noise="sensors", seed=1)
    assert identify(robot, flown, initial_momentum="at-rest").status == "ok"


def test_motions_that_break_a_limit_as_panels_swing_are_refused(tmp_path: Path):
    robot = swinging_satellite(tmp_path)
    limits = limits_of(robot, base_rate=1e-6)
    given = conditions_for(robot, 10.0, limits=limits)

    def design(twin: Robot, conditions: Conditions, **_: object) -> Trajectory:
        assert not twin.passive
        a = np.array([[0.1], [0.1], [0.0], [0.0]])
        return Trajectory(
            conditions.duration,
            twin.joint_names,
            a,
            0 * a,
            given.start,
            given.end,
            given.initial,
            design={"starts": 1, "interrupted": False},
        )

    with pytest.raises(InputError, match="as its joints swing, none of 2 motions"):
        design_swinging(robot, given, Effort(2, None), (3, 6), design)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"objective": "cond"}, "objective cond"),
        ({"recordings": 2}, "several recordings"),
    ],
)
def test_what_needs_stiff_joints_is_refused(tmp_path: Path, asked, words):
    robot = swinging_satellite(tmp_path)
    given = conditions_for(robot, 10.0)
    with pytest.raises(InputError, match=rf"{words}.*with joints that swing"):
        next(design_recordings(robot, asked.pop("recordings", 1), given, **asked))


def test_a_robot_whose_joints_are_all_passive_is_refused(tmp_path: Path):
    robot = swinging_satellite(tmp_path)
    spring = robot.passive["panel_left"]
    alone = replace(robot, passive=dict.fromkeys(robot.joint_names, spring))
    with pytest.raises(InputError, match="all are passive"):
        stiff(alone)
    with pytest.raises(InputError, match="all are passive"):
        design_excitation(alone, duration=10.0)


def test_motions_beside_which_joints_swing_are_not_compared(tmp_path: Path):
    from orbident.excitation.scores import compare_trajectories

    robot = swinging_satellite(tmp_path)
    with pytest.raises(InputError, match=r"comparison of motions.*orbident inspect"):
        compare_trajectories(robot, [])
