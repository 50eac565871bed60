"""Numbers that may be wrong, found to first order, and tried."""

from dataclasses import replace

import numpy as np
import pytest
from cause_problems import clean, fitted, problem_with, with_recording
from edited_recordings import changed
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.diagnosis.filters import filters
from orbident.diagnosis.frames import beside, missing_wheel, point_of_a_link
from orbident.diagnosis.shifts import curved_scales
from orbident.diagnosis.suspects import Scores, Suspect
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.output_error.problem import Problem, linear, problem_of
from orbident.estimation.output_error.sensors import sensors_of
from orbident.estimation.solution import Solution
from orbident.estimation.unknowns import Score, score
from orbident.model.kinematics import poses
from orbident.preprocessing.delays import delays


def best(problem: MomentumProblem, suspects) -> tuple[Suspect, Score]:
    solution = fitted(problem).solution
    assert solution is not None
    every = [*suspects]
    scores = zip(every, Scores(problem, solution).of(every), strict=True)
    return max(scores, key=lambda one: one[1].fall)


@pytest.mark.slow
def test_scores_are_those_of_a_step_of_all_else():
    """Beside the plain way: every changed recording is linearised, all other unknowns
    take one step, and what is left is compared."""
    x = clean().recording.columns["position.x"]
    problem = problem_with({"position.x": lambda _: 1.0003 * x + 1e-3})
    solution = fitted(problem).solution
    assert solution is not None
    suspects = [*beside(problem), *filters(problem), *curved_scales(problem)]
    scores = Scores(problem, solution)
    before = left(scores.equations, solution)
    for suspect, found in zip(suspects, scores.of(suspects), strict=True):
        D = np.column_stack(
            [
                left(equations_of(suspect.corrected(problem, c)), solution) - before
                for c in np.diag(suspect.small)
            ]
        )
        plain = score(D / suspect.small, -before)
        np.testing.assert_allclose(found.fall, plain.fall, rtol=0.01, atol=0.05)
        np.testing.assert_allclose(found.std, plain.std, rtol=0.01)
        off = np.abs(found.values - plain.values) / plain.std
        assert off.max() < 0.01 * np.sqrt(plain.fall) + 0.05


def equations_of(problem: MomentumProblem) -> Problem:
    robot, samples = problem.robot, problem.samples
    late = delays(robot, problem.recording, problem.late)
    sensors = sensors_of(robot, problem.recording, late, samples.speeds)
    return problem_of(robot, problem.sets, samples, sensors)


def left(equations: Problem, solution: Solution) -> np.ndarray:
    """Residuals of all sensors after one step of all unknowns."""
    state, weights = solution.state, solution.weights
    here = linear(equations, weights, state)
    factor = solution.prior.added(here.common, state)
    g = np.linalg.solve(factor[:-1, :-1], factor[:-1, -1])
    there = linear(equations, weights, state.moved(here.step(g), g)).residuals
    return np.concatenate([table.ravel() for table in there.values()])


def test_inertial_axes():
    """Positions turned by 20 mrad about z."""
    c, s = np.cos(0.02), np.sin(0.02)
    columns = clean().recording.columns
    x, y = columns["position.x"], columns["position.y"]
    problem = problem_with(
        {
            "position.x": lambda _: c * x - s * y,
            "position.y": lambda _: s * x + c * y,
        }
    )
    suspect, first = best(problem, beside(problem))
    assert "different inertial axes" in suspect.words(first.values)
    np.testing.assert_allclose(
        first.values, [0.0, 0.0, -0.02], atol=5 * first.std.max()
    )


def test_a_wheel_that_the_robot_file_lacks():
    """One of three is missing; what it has along the other two together is another
    scale."""
    robot, gone = clean().robot, clean().robot.wheels[0]
    recording = changed(
        clean().recording,
        keep=lambda name: not name.startswith(f"wheel.{gone.name}."),
    )
    fewer = replace(robot, wheels=robot.wheels[1:])
    problem = momentum_problem(fewer, recording, "unknown", lambda _: None)
    (found,) = missing_wheel(problem)
    assert found.accepted
    assert "a wheel is missing" in found.cause


def test_a_tracked_point_on_a_link():
    """The marker is 0.1 m from the second joint, on the link behind it."""
    problem, x = problem_with(), np.array([0.06, 0.0, 0.08])
    at = poses(clean().robot, np.column_stack(problem.samples.q))
    R_WB = Rotation.from_quat(np.column_stack(problem.samples.x_WB))
    p = clean().recording.vector("position") + R_WB.apply(at.arm(2, x))
    columns = {f"position.{k}": part for k, part in zip("xyz", p.T, strict=True)}
    spoiled = with_recording(changed(clean().recording, columns))
    (found,) = point_of_a_link(spoiled)
    assert f"is on link {clean().robot.bodies[2]}, 0.1 m from joint joint2" in (
        found.cause
    )
    assert [*point_of_a_link(problem)] == []
    every = clean().recording.columns.items()
    columns = {name: x for name, x in every if not name.startswith("position.")}
    blind = replace(problem, recording=replace(problem.recording, columns=columns))
    assert [*point_of_a_link(blind)] == []


def test_no_wheel_is_missing():
    assert [*missing_wheel(problem_with())] == []


def test_a_gyro_whose_scale_changes_with_the_rate():
    """It shows 2 % more at its largest rate about x, and less in proportion below."""
    rate = clean().recording.columns["gyro.x"]
    most = np.abs(clean().recording.vector("gyro")).max()
    problem = problem_with({"gyro.x": lambda x: x * (1 + 0.02 * np.abs(rate) / most)})
    suspect, first = best(problem, [*curved_scales(problem), *filters(problem)])
    assert "scale of the gyro depends on what it shows" in suspect.words(first.values)
    # `a` of x, y, z, and then `b`.
    assert abs(first.values[3] - 0.02) < 5 * first.std[3]


@pytest.mark.slow
def test_a_lens():
    """A size that the score knows to first order."""
    p = clean().recording.columns["position.y"]
    most = np.abs(clean().recording.vector("position")).max()
    problem = problem_with({"position.y": lambda y: y * (1 + 0.01 * (p / most) ** 2)})
    suspect, first = best(problem, [*curved_scales(problem), *filters(problem)])
    assert "scale of the position depends" in suspect.words(first.values)
    assert abs(first.values[4] - 0.01) < 5 * first.std[4]


def test_tachometers_behind_filters():
    """A low-pass filter of 50 ms on all of them."""
    robot, dt = clean().robot, 1 / clean().robot.sensors.rows_per_second
    keep, late = np.exp(-dt / 0.05), {}
    recording = clean().recording
    for name in robot.wheel_names:
        speed = np.gradient(recording.columns[f"wheel.{name}.position"], recording.t)
        shown = speed.copy()
        for k in range(1, shown.size):
            shown[k] = keep * shown[k - 1] + (1 - keep) * speed[k]
        late[f"wheel.{name}.speed"] = shown
    fast = momentum_problem(robot, changed(recording, late), "unknown", lambda _: None)
    words = [each.words(np.array([0.05, 0.0])) for each in filters(fast)]
    assert (
        "the samples of the wheels are 50 ms late, by a filter or by the clock" in words
    )


def test_encoders_behind_filters():
    """All joints are 50 ms late."""
    recording = clean().recording
    names = [f"joint.{name}.position" for name in clean().robot.joint_names]
    late = {
        name: CubicSpline(recording.t, recording.column(name))(recording.t - 0.05)
        for name in names
    }
    problem = with_recording(recording.with_columns(late))
    suspect, first = best(problem, filters(problem))
    assert "the samples of the joints are" in suspect.words(first.values)
    np.testing.assert_allclose(first.values[0], 0.05, rtol=0.1)
