"""What MuJoCo flies for the table of real effects, beside other ways to know it."""

import numpy as np
import pytest
from effects_on_robots import flexible, panels
from flown import flown, in_mujoco
from parts_on_board import Base, ball, driven, moving, plate
from recordings import SPACE, TABLE, Clean, clean, motion_of
from spoiled import Spoil

from orbident.robot.description import Robot
from orbident.simulation.measure import Truth
from orbident.trajectories.trajectory import Trajectory

EXACT = 1e-7
"""rad, m and s: MuJoCo's error and that of the splines are below 1e-8."""


def assert_alike(flown: Truth, simulated: Truth) -> None:
    joints = flown.q.shape[1]
    np.testing.assert_allclose(flown.q, simulated.q[:, :joints], atol=EXACT)
    np.testing.assert_allclose(flown.gyro, simulated.gyro, atol=EXACT)
    np.testing.assert_allclose(flown.position, simulated.position, atol=EXACT)
    same = np.abs(np.sum(flown.attitude * simulated.attitude, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=EXACT)


@pytest.mark.parametrize("name", [pytest.param(SPACE, marks=pytest.mark.slow), TABLE])
def test_a_robot_as_described_moves_as_simulated(name: str):
    """Between rows, too."""
    known = clean(name)
    inside = np.random.default_rng(0).uniform(0, known.t[-1], 50)
    t = np.sort(np.append(0.0, inside))
    assert_alike(in_mujoco(known).at(t), known.at(t))


def check_joint(known: Clean, robot: Robot, rate: float, swing: float) -> None:
    """Flown, and compared with what is simulated of the same joints."""
    assert isinstance(known.joints, Trajectory)
    motion = moving(robot.joint_names[-1], rate, swing)
    shown = flown(known, robot, motion)
    simulated = motion_of(robot, motion(known.joints), known.start, known.t)
    assert_alike(shown.true, simulated)


@pytest.mark.slow
def test_an_array_turns_as_simulated():
    known = clean(SPACE)
    array = plate("array", Base.of(known.robot), 0.012, 1.0)
    axis = np.array([0.0, 1.0, 0.0])
    check_joint(known, driven(known.robot, array, "revolute", axis), 0.02, 0.0)


def test_a_carriage_slides_as_simulated():
    known = clean(TABLE)
    slide = ball("carriage", Base.of(known.robot), 0.02, (0.3, -0.5, 0.0))
    axis = np.array([0.6, 0.8, 0.0])
    check_joint(known, driven(known.robot, slide, "prismatic", axis), 0.0, 0.02)


@pytest.mark.parametrize(
    "swings",
    [panels, pytest.param(flexible, marks=pytest.mark.slow)],
    ids=["panels", "joint2"],
)
def test_stiff_springs_are_rigid(swings):
    """What is on a spring gives way as the inverse square of its frequency."""
    soft, stiff = off(swings(1.0)), off(swings(8.0))
    assert stiff < soft / 16


def off(spoil: Spoil) -> float:
    """The attitude beside that of the rigid robot, with the same noise."""
    rigid = in_mujoco(clean(TABLE)).recorded().vector("attitude", "xyzw")
    shown = spoil(clean(TABLE)).recording.vector("attitude", "xyzw")
    return float(np.abs(shown - rigid).max())
