"""What laboratories do wrong with columns of thrusters is named: flights by sums."""

from dataclasses import replace

import numpy as np
import pytest
from valved_satellite import Truth, flown, satellite, with_dead

from orbident.diagnosis.frames import point_of_a_link
from orbident.diagnosis.recorded_pulses import (
    pulses_put_right,
    shown_pulses,
    slow_duty,
)
from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import InitialState, Trajectory

KNOWN = "known: {mass: 23.09 +- 0.01 kg}\n"
CORNER = np.roll(np.arange(8), 2)
ROW = 1 / 16
"""s: of `flown`."""


def truth(seed: int) -> Truth:
    random = np.random.default_rng(1000 + seed)
    gains = 0.1 * random.standard_normal(8)
    return Truth(gains=gains, coupling=0.02, tilt=tuple(1e-3 * random.normal(size=2)))


def duty(recording: Recording) -> np.ndarray:
    names = [f"thruster.t{k}.duty" for k in range(1, 9)]
    return np.column_stack([recording.column(name) for name in names])


def commanded(recording: Recording, on: np.ndarray) -> Recording:
    return recording.with_columns(
        {f"thruster.t{k}.duty": column for k, column in enumerate(on.T, start=1)}
    )


def put_right(robot: Robot, recording: Recording) -> str:
    """The cause that is tried, which explains the recording."""
    (one,) = pulses_put_right(problem_of(robot, recording))
    assert one.accepted
    return one.cause


def problem_of(robot: Robot, recording: Recording) -> MomentumProblem:
    return momentum_problem(robot, recording, "unknown", lambda _: None)


def cause(robot: Robot, recording: Recording) -> str:
    """The same from one end to the other, which takes longer."""
    result = identify(robot, recording).with_causes()
    assert result.status == "rejected"
    return next(check.reason for check in result.checks if check.name == "cause")


@pytest.mark.parametrize(("seed", "valve"), [(1, 0), (2, 3)])
def test_numbered_from_another_corner(tmp_path, seed, valve):
    """With a dead valve or without."""
    true = with_dead(truth(seed), valve) if valve else truth(seed)
    seen = flown(true, seed)
    robot, other = (
        satellite(tmp_path, more=KNOWN),
        commanded(seen, duty(seen)[:, CORNER]),
    )
    named = put_right(robot, other)
    assert "numbered from another corner: what is recorded as t1 is t7" in named


@pytest.mark.long
def test_a_refusal_names_it(tmp_path):
    """The whole way, as of directions below, to a cause that is tried above."""
    seen = flown(truth(1), 1, duration=25.0)
    named = cause(
        satellite(tmp_path, more=KNOWN), commanded(seen, duty(seen)[:, CORNER])
    )
    assert "numbered from another corner: what is recorded as t1 is t7" in named
    assert "the recording is accepted" in named


def test_exchanged(tmp_path):
    seen = flown(truth(1), 1)
    order = [1, 0, *range(2, 8)]
    named = put_right(
        satellite(tmp_path, more=KNOWN), commanded(seen, duty(seen)[:, order])
    )
    assert named.endswith("exchanged: what is recorded as t1 is t2, t2 is t1")


def test_directions_of_the_gas(tmp_path):
    robot = satellite(tmp_path, more=KNOWN)
    gas = tuple(replace(each, direction=-each.direction) for each in robot.thrusters)
    named = cause(replace(robot, thrusters=gas), flown(truth(1), 1))
    assert "thrusters push the other way than the robot file says" in named


@pytest.mark.parametrize(
    ("late", "valve"), [pytest.param(-3.0, 2, marks=pytest.mark.slow), (1.0, 0)]
)
def test_another_zero_of_time(tmp_path, late, valve):
    """Columns are `late` after what was commanded, and valves 0.15 s after that.

    That alone is said, with a dead valve or without.
    """
    seen = flown(with_dead(truth(1), valve) if valve else truth(1), 1)
    rows = round(late / ROW)
    on = np.roll(duty(seen), rows, axis=0)
    on[slice(rows, None) if rows < 0 else slice(rows)] = 0.0
    named = put_right(satellite(tmp_path, more=KNOWN), commanded(seen, on))
    way = "before" if late > 0 else "after"
    assert named.startswith(
        f"the commands of thrusters act {abs(0.1 - late):.2g} s {way} the times"
    )


@pytest.mark.parametrize("every", [4, 16])
def test_recorded_more_slowly_than_pulses_are_long(tmp_path, every):
    seen = flown(truth(1), 1)
    on = duty(seen)[np.arange(seen.t.size) // every * every]
    problem = problem_of(satellite(tmp_path, more=KNOWN), commanded(seen, on))
    assert not [*pulses_put_right(problem)]
    named = slow_duty(problem) or ""
    assert f"it changes every {every * ROW:.3g} s at most" in named


def test_in_percent(tmp_path):
    seen = flown(truth(1), 1)
    with pytest.raises(InputError, match="if it is in percent, divide it by 100"):
        identify(satellite(tmp_path), commanded(seen, 100 * duty(seen)))


def test_nothing_is_said_of_what_is_right(tmp_path):
    """The true time and effect of every column, and no cause."""
    robot, seen = satellite(tmp_path), flown(truth(3), 3)
    problem = problem_of(robot, seen)
    assert not [*pulses_put_right(problem)]
    shown = shown_pulses(problem)
    assert shown is not None
    assert shown.late == pytest.approx(0.14, abs=0.05)
    assert shown.alike.diagonal().min() > 0.98
    assert slow_duty(problem) is None


def test_no_link_has_the_marker_of_a_robot_without_joints(tmp_path):
    """It was an internal error."""
    problem = problem_of(satellite(tmp_path), flown(truth(4), 4))
    assert [*point_of_a_link(problem)] == []


def test_in_space_with_wheels(tmp_path):
    """Six thrusters by the simulator, the first two exchanged."""
    ways = [(k, s) for k in range(3) for s in (1.0, -1.0)]
    jets = "".join(
        f"  - {{name: t{n}, position: {np.roll([0.4, 0.2, 0.1], k).tolist()}, "
        f"direction: {(s * np.eye(3)[k]).tolist()}}}\n"
        for n, (k, s) in enumerate(ways)
    )
    path = tmp_path / "box.yaml"
    path.write_text(
        "schema: orbident/robot/1\nname: box\n"
        "bodies:\n  box: {mass: 50 kg, inertia: [4, 5, 6]}\n"
        f"thrusters:\n{jets}"
        "wheels:\n  - {name: w, axis: [0, 0, 1], inertia: 0.01}\n"
    )
    random, none = np.random.default_rng(1), np.zeros((0, 3))
    pulses: dict[str, dict] = {f"t{k}": {"pulses": []} for k in range(6)}
    for k in range(28):
        name = f"t{random.integers(6)}"
        on, off = 1.0 + k, 1.0 + k + random.uniform(0.3, 0.9)
        pulses[name]["pulses"].append({"on": on, "off": off, "force": 0.5})
    motion = Trajectory(
        *(30.0, (), np.zeros((0, 0)), np.zeros((0, 0)), none, none),
        InitialState(wheel_speed={"w": 50.0}),
        Environment.model_validate({"thrusters": pulses}),
    )
    robot = load_robot(path)
    seen = simulate(robot, motion, rate=20.0)
    columns = dict(seen.columns)
    one, other = "thruster.t0.force", "thruster.t1.force"
    columns[one], columns[other] = columns[other], columns[one]
    shown = shown_pulses(problem_of(robot, replace(seen, columns=columns)))
    assert shown is not None
    assert shown.late == pytest.approx(0.0, abs=0.05)
    expected = np.eye(6)[[1, 0, 2, 3, 4, 5]]
    assert shown.alike[expected > 0] == pytest.approx(1.0, abs=0.02)
