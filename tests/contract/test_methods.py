"""What every method of identification must do, whatever it is inside."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from edited_recordings import changed
from random_motions import Start, random_motion
from random_robots import random_robot, random_wheels
from truth import truth

from orbident.estimation.identify import METHODS, Method, identify
from orbident.estimation.quantities import Parameters
from orbident.estimation.result import Identified, Result
from orbident.identified.run_folder import load_result, save_result
from orbident.identified.validate import validate
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.simulate import simulate

pytestmark = pytest.mark.parametrize("method", METHODS)

EXACT = 1e-9
"""Relative error without noise. Maximum likelihood adds the splines and the RK4 that go
from row to row: some 1e-10 at 20 rows a second."""

UNEVEN: dict[Method, float] = {
    "maximum-likelihood": 1e-5,
    "structured": EXACT,
    "least-squares": EXACT,
    "recursive": EXACT,
}
"""Where rows are up to half a second apart. Others take each row for itself; maximum
likelihood predicts from row to row with splines: (0.3 s)^4 of a radian."""

FROM_AFAR: dict[Method, float] = {**dict.fromkeys(METHODS, EXACT), "recursive": 1e-7}
"""Tolerance where CAD values are a fifth too large: what the recursive filter starts
from weighs as much as its declared noise, 1e-5 rad/s, lets it."""


LINEAR: tuple[Method, ...] = ("structured", "least-squares")


@pytest.fixture(scope="module")
def identified(robot: Robot, recording: Recording) -> Callable[[Method], Result]:
    """Identify the exact recording, once by each method."""
    return cache(lambda method: identify(robot, recording, method))


def values(result: Identified) -> dict[str, np.ndarray]:
    return {name: getattr(result, name).values for name in ("pi", "phi", "base")} | {
        "mass": np.array([result.mass.value])
    }


def check_close(
    found: Mapping[str, np.ndarray],
    true: Mapping[str, np.ndarray],
    tolerance: float = EXACT,
) -> None:
    """Relative to each set's largest."""
    for name, expected in true.items():
        error = np.abs(found[name] - expected).max() / np.abs(expected).max()
        assert error < tolerance, name


def test_exact_data_are_recovered(
    method: Method, robot: Robot, recording: Recording, identified
):
    result = identified(method)
    assert result.status == "ok"
    assert result.warnings == ()
    assert result.method == method
    assert result.samples == recording.t.size
    check_close(values(result), truth(robot))


def test_the_nominal_inertia_is_not_the_answer(
    method: Method, robot: Robot, recording: Recording
):
    """A CAD model 20 % too heavy must not show in the result."""
    result = identify(replace(robot, theta=1.2 * robot.theta), recording, method)
    check_close(values(result), truth(robot), FROM_AFAR[method])


def test_all_estimates_have_deviations(method: Method, identified):
    result = identified(method)
    for estimates in (result.pi, result.phi, result.base, result.mass_forms):
        assert isinstance(estimates, Parameters)
        assert np.isfinite(estimates.std).all()
        assert (estimates.std >= 0).all()
    assert result.mass.std >= 0
    C = result.covariance
    assert C is not None
    assert C.shape == (result.pi.values.size + result.phi.values.size,) * 2
    np.testing.assert_allclose(C, C.T, atol=1e-12 * np.abs(C).max())
    deviations = np.concatenate([result.pi.std, result.phi.std])
    np.testing.assert_allclose(np.sqrt(np.diag(C)), deviations)
    B = result.base_covariance
    np.testing.assert_allclose(np.sqrt(np.diag(B)), result.base.std)


def test_a_kept_result_has_its_covariances(method: Method, identified, tmp_path):
    result = identified(method)
    save_result(result, tmp_path / "run")
    kept = load_result(tmp_path / "run")
    # Of a symmetric matrix one half is kept.
    rounding = 1e-12 * np.abs(result.covariance).max()
    np.testing.assert_allclose(kept.covariance, result.covariance, atol=rounding)
    np.testing.assert_array_equal(kept.base_covariance, result.base_covariance)
    np.testing.assert_array_equal(kept.pi.std, result.pi.std)
    np.testing.assert_array_equal(kept.convergence, result.convergence)


def test_the_search_is_shown(method: Method, identified):
    """The last step is small; a method without a search has none."""
    steps = identified(method).convergence
    assert bool(steps) == (method in {"maximum-likelihood", "structured"})
    assert all(step.size < 0.01 for step in steps[-1:])


def test_fewer_rows_give_the_same(method: Method, robot: Robot, recording: Recording):
    some = np.sort(np.random.default_rng(0).permutation(recording.t.size)[:300])
    result = identify(robot, changed(recording, rows=some), method)
    check_close(values(result), truth(robot), UNEVEN[method])


def test_rows_that_lack_something_are_ignored(
    method: Method, robot: Robot, recording: Recording
):
    """Whatever else stands in a row without gyro or attitude does not count.

    To the linear methods, which need all of a row; the velocities of such rows are
    wrong here. Maximum likelihood uses every sample, and they are right.
    """
    random = np.random.default_rng(0)
    holes = {}
    for sensor, every in (("gyro", 3), ("attitude", 4)):
        for name, column in recording.columns.items():
            if name.startswith(sensor):
                holes[name] = column.copy()
                holes[name][::every] = np.nan
    wrong = np.isnan(holes["gyro.x"]) | np.isnan(holes["attitude.x"])
    for name in ("velocity.x", "velocity.y") if method in LINEAR else ():
        holes[name] = np.where(
            wrong, random.standard_normal(wrong.size), recording.columns[name]
        )
    result = identify(robot, changed(recording, holes), method)
    assert result.samples == np.count_nonzero(~wrong)
    check_close(values(result), truth(robot))


def test_velocity_may_have_its_own_gaps(
    method: Method, robot: Robot, recording: Recording
):
    holes = {f"velocity.{k}": recording.columns[f"velocity.{k}"].copy() for k in "xyz"}
    for column in holes.values():
        column[np.arange(column.size) % 5 != 0] = np.nan
    result = identify(robot, changed(recording, holes), method)
    assert result.samples == recording.t.size
    check_close(values(result), truth(robot))


def test_columns_that_mean_nothing_do_not_matter(
    method: Method, robot: Robot, recording: Recording, identified
):
    """Nor does the order of the columns."""
    extra = {"temperature": np.full(recording.t.size, np.nan)}
    reverse = dict(reversed({**recording.columns, **extra}.items()))
    result = identify(robot, Recording(recording.t, reverse), method)
    check_close(values(result), values(identified(method)), 1e-15)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_heavier_robots(
    method: Method, robot: Robot, recording: Recording, factor: float
):
    """`pi`, `sigma`, `iota` and `M` scale with mass, `phi` does not. With wheels as
    much heavier the same motion is a heavier robot's."""
    wheels = tuple(replace(w, inertia=factor * w.inertia) for w in robot.wheels)
    heavier = replace(robot, theta=factor * robot.theta, wheels=wheels)
    check_close(values(identify(heavier, recording, method)), truth(heavier))


@pytest.mark.parametrize("factor", [1e-2, 1e2])
def test_longer_robots(
    method: Method, robot: Robot, recording: Recording, factor: float
):
    """In other units of length: first moments scale once, inertias twice."""
    joints = tuple(replace(j, p_PJ=factor * j.p_PJ) for j in robot.joints)
    scale = np.array([1.0] + [factor] * 3 + [factor**2] * 6)
    wheels = tuple(replace(w, inertia=factor**2 * w.inertia) for w in robot.wheels)
    longer = replace(robot, joints=joints, theta=scale * robot.theta, wheels=wheels)
    faster = {
        name: factor * column
        for name, column in recording.columns.items()
        if name.startswith(("velocity", "position"))
    }
    result = identify(longer, changed(recording, faster), method)
    check_close(values(result), truth(longer))


def test_another_clock(method: Method, robot: Robot, recording: Recording):
    """Where time begins does not matter."""
    later = Recording(recording.t + 1.7e9, recording.columns)
    check_close(values(identify(robot, later, method)), truth(robot))


def test_bursts_without_samples(method: Method, robot: Robot, recording: Recording):
    """Each sensor of the base is silent for some seconds, at times of its own."""
    holes = {}
    for k, sensor in enumerate(("gyro", "attitude", "velocity", "position")):
        silent = (recording.t > 5 + 6 * k) & (recording.t < 9 + 6 * k)
        for name, column in recording.columns.items():
            if name.startswith(sensor):
                holes[name] = np.where(silent, np.nan, column)
    result = identify(robot, changed(recording, holes), method)
    assert result.status == "ok"
    check_close(values(result), truth(robot))


def test_short_numbers(method: Method, robot: Robot, recording: Recording):
    """Columns of float32, as many loggers write: rounded to 6e-8 of themselves."""
    short = {
        name: column.astype(np.float32) for name, column in recording.columns.items()
    }
    result = identify(robot, changed(recording, short), method)
    assert result.status == "ok"
    # Conditions of some hundred, 800 rows to average over.
    check_close(values(result), truth(robot), 1e-5)


def test_it_predicts(method: Method, robot: Robot, identified):
    result = identified(method)
    other = simulate(robot, random_motion(robot, seed=5, duration=10.0))
    scores = validate(result, other)
    assert scores.samples == other.t.size
    # The spline between 20 samples a second.
    assert max(scores.nrmse.values()) < 1e-6


@pytest.mark.parametrize("start", ["at rest", "spun up"])
def test_momentum_that_is_known(method: Method, robot: Robot, start: Start):
    """That of the wheels of a base at rest; zero where the wheels made it turn."""
    exact = simulate(robot, random_motion(robot, start=start, wheel_speed=400.0))
    result = identify(robot, exact, method, "at-rest")
    assert (result.status, result.warnings) == ("ok", ())
    check_close(values(result), truth(robot))


def test_a_body_without_joints(method: Method):
    """Its inertia shows; its mass does not, and is not told."""
    body = random_robot(5, (), wheels=random_wheels(5, ("held", "held", "free")))
    drifting = simulate(body, random_motion(body, 1, 20.0, 100.0))
    result = identify(body, drifting, method)
    assert result.status == "rejected"
    assert np.isnan(result.mass.value)
    # Rows of a base that turns at several radians a second, 0.05 s apart: RK4.
    close = {name: truth(body)[name] for name in ("pi", "phi")}
    assert np.isnan(result.phi.values).all()
    assert result.diagnostics is not None
    found = values(result.diagnostics)
    check_close(found, close, EXACT if method in LINEAR else 1e-5)


def test_inputs_are_left_alone(method: Method, robot: Robot, recording: Recording):
    before = {name: column.copy() for name, column in recording.columns.items()}
    theta = robot.theta.copy()
    identify(robot, recording, method)
    np.testing.assert_array_equal(robot.theta, theta)
    for name, column in before.items():
        np.testing.assert_array_equal(recording.columns[name], column)


def test_twice_the_same(method: Method, robot: Robot, recording: Recording, identified):
    second = values(identify(robot, recording, method))
    for name, expected in values(identified(method)).items():
        np.testing.assert_array_equal(second[name], expected)


def test_progress_is_told(method: Method, robot: Robot, recording: Recording):
    told: list[float] = []
    identify(robot, recording, method, progress=told.append)
    assert told
    assert told == sorted(told)
    assert all(0 <= fraction <= 1 for fraction in told)
