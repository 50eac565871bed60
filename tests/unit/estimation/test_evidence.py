"""Deviations of other methods by what sensors show, and how much is looked at."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from random_robots import random_planar_robot
from small_problems import noisy, small_recording, small_robot

from orbident.estimation import clock_search as module
from orbident.estimation.base_parameters import Known
from orbident.estimation.clock_search import evidence
from orbident.estimation.estimate import Estimate
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.quantities import Quantity
from orbident.estimation.widening import difference, widened
from orbident.recordings.recording import Recording
from orbident.robot.description import Wheel
from orbident.simulation.simulate import simulate

ROBOT = small_robot()


def problem_of(recording: Recording) -> MomentumProblem:
    return momentum_problem(ROBOT, recording, "at-rest", lambda _: None)


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    return problem_of(noisy(small_recording(ROBOT), 0))


@pytest.fixture(scope="module")
def shown(problem: MomentumProblem) -> Estimate:
    return OutputError().estimate(problem, lambda _: None)


def sets_of(estimate: Estimate) -> tuple[Known, Known, Known]:
    return estimate.parameters.pi, estimate.parameters.phi, estimate.parameters.base


def off_by(estimate: Estimate, problem: MomentumProblem, deviations: float) -> Estimate:
    """Every base parameter is off by so many deviations, and so is all that follows."""
    found = estimate.parameters
    std = np.sqrt(np.diag(found.base.covariance))
    beta = found.base.values + deviations * std
    pi, phi = problem.sets.pi_and_phi(beta)
    moved = found._replace(
        pi=found.pi._replace(values=pi),
        phi=found.phi._replace(values=phi),
        base=found.base._replace(values=beta),
    )
    mass = Quantity(float(beta[0]), estimate.mass.std)
    return replace(estimate, parameters=moved, mass=mass)


def test_an_estimate_that_agrees_keeps_its_variance(shown):
    same = widened(shown, shown, True)
    for one, other in zip(sets_of(same), sets_of(shown), strict=True):
        np.testing.assert_array_equal(one.values, other.values)
        np.testing.assert_array_equal(one.covariance, other.covariance)
    assert same.mass == shown.mass
    assert difference(shown.parameters.base, shown.parameters.base) == 0


def test_an_estimate_that_is_off_has_its_distance_in_its_deviations(problem, shown):
    """Beside its own variance, where the sensors' is of a part."""
    sure = shown.parameters._replace(
        **{
            name: known._replace(covariance=known.covariance / 4)
            for name, known in zip(("pi", "phi", "base"), sets_of(shown), strict=True)
        },
        covariance=shown.parameters.covariance / 4,
    )
    mass = Quantity(shown.mass.value, shown.mass.std / 2)
    mine = off_by(replace(shown, parameters=sure, mass=mass), problem, 3.0)
    wide = widened(mine, shown, False)
    for now, before, there in zip(
        sets_of(wide), sets_of(mine), sets_of(shown), strict=True
    ):
        np.testing.assert_array_equal(now.values, before.values)
        d = before.values - there.values
        np.testing.assert_allclose(
            np.sqrt(np.diag(now.covariance)),
            np.sqrt(np.diag(before.covariance) + d**2),
            rtol=1e-12,
        )
        check_semidefinite(now.covariance)
    assert difference(mine.parameters.base, shown.parameters.base) == pytest.approx(3.0)
    assert wide.mass.std == pytest.approx(
        np.hypot(mine.mass.std, mine.mass.value - shown.mass.value)
    )


@pytest.mark.parametrize("deviations", [0.3, 1.0, 3.0, 30.0])
def test_intervals_of_what_is_off_hold_as_much_as_they_say(problem, shown, deviations):
    """Maximum likelihood's errors, drawn, beside estimates that are off from it."""
    rng = np.random.default_rng(0)
    base = shown.parameters.base
    std = np.sqrt(np.diag(base.covariance))
    mine = off_by(shown, problem, 0.0)
    off = deviations * std * rng.normal(size=std.size)
    moved = mine.parameters.base._replace(values=base.values + off)
    wide = widened(
        replace(mine, parameters=mine.parameters._replace(base=moved)), shown, True
    ).parameters.base
    true = base.values + std * rng.normal(size=(20_000, std.size))
    half = 1.959964 * np.sqrt(np.diag(wide.covariance))
    held = np.mean(np.abs(true - moved.values) < half)
    # 20,000 draws of each parameter: 0.001 is twice the deviation of what they show.
    assert held == pytest.approx(0.95, abs=1e-3)
    check_semidefinite(wide.covariance)


def test_all_descriptions_are_as_sure(problem, shown):
    """`M` as the first of the base parameters; `pi` and `phi` as both together."""
    wide = widened(off_by(shown, problem, 3.0), shown, True)
    pi, phi, base = sets_of(wide)
    assert wide.mass.std == pytest.approx(np.sqrt(base.covariance[0, 0]))
    *_, last = wide.masses.values()
    assert last == wide.mass
    n, both = pi.values.size, wide.parameters.covariance
    # The blocks were products of the same matrices.
    np.testing.assert_allclose(both[:n, :n], pi.covariance, rtol=1e-9)
    np.testing.assert_allclose(both[n:, n:], phi.covariance, rtol=1e-9)
    check_semidefinite(both)


def check_semidefinite(C: np.ndarray) -> None:
    std = np.sqrt(np.diag(C))
    correlations = C / np.outer(std, std)
    np.testing.assert_allclose(correlations, correlations.T, atol=1e-12)
    # Rounding of as many numbers as a row has.
    assert np.linalg.eigvalsh(correlations).min() > -1e-12


def test_what_is_not_determined_widens_nothing(problem, shown):
    mine = off_by(shown, problem, 3.0)
    base = mine.parameters.base._replace(
        determined=np.arange(mine.parameters.base.values.size) > 0
    )
    mine = replace(mine, parameters=mine.parameters._replace(base=base))
    wide = widened(mine, shown, True).parameters.base
    before = shown.parameters.base.covariance
    assert wide.covariance[0, 0] == before[0, 0]
    assert (np.diag(wide.covariance)[1:] > 5 * np.diag(before)[1:]).all()
    assert not wide.determined[0]


def test_exact_data_need_no_other_witness():
    exact = problem_of(small_recording(ROBOT))
    assert evidence(exact, LeastSquares(), lambda _: None).shown is None
    whole = evidence(exact, OutputError(), lambda _: None)
    assert whole.shown is not None


def test_the_beginning_of_a_problem(problem):
    """That of its samples, on its clocks, with equations of its own."""
    part = problem.beginning(200)
    np.testing.assert_array_equal(part.samples.t, problem.samples.t[:200])
    assert part.clocks == problem.clocks
    columns = problem.recording.columns
    first = Recording(
        problem.recording.t[:200], {name: x[:200] for name, x in columns.items()}
    )
    alone = problem_of(first)
    np.testing.assert_allclose(
        part.fits.pi.values, alone.fits.pi.values, rtol=1e-12, atol=1e-12
    )
    assert problem.beginning(problem.recording.t.size) is problem


def test_other_methods_are_judged_by_the_beginning(problem, monkeypatch):
    monkeypatch.setattr(module, "MOST", 200)
    for estimator, rows in (
        (LeastSquares(), 200),
        (OutputError(), problem.recording.t.size),
    ):
        found = evidence(problem, estimator, lambda _: None)
        assert found.problem.samples is problem.samples
        assert found.shown is not None
        sizes = {len(signal.measured) for signal in found.shown.signals}
        assert sizes == {rows}


@pytest.mark.parametrize(
    ("seed", "late"), [(0, 3.0), pytest.param(1, -3.0, marks=pytest.mark.slow)]
)
def test_clocks_that_are_seconds_apart_are_seen(seed: int, late: float):
    """Without a gyro, of random robots on a table that spin up from rest."""
    wheel = Wheel("rw", np.array([0.0, 0.0, 1.0]), 0.05)
    robot = random_planar_robot(seed, (0, 1), wheels=[wheel])
    motion = random_motion(robot, seed, duration=60.0, start="spun up")
    slower = 0.3 ** np.arange(motion.a.shape[1])
    motion = replace(motion, a=slower * motion.a, b=slower * motion.b)
    true = simulate(robot, motion, rate=20.0)
    n = round(20 * abs(late))
    ahead, behind = slice(n, None), slice(None, -n)
    of_joints, of_base = (behind, ahead) if late > 0 else (ahead, behind)
    columns = {
        name: column[of_joints if name.startswith(("joint", "wheel")) else of_base]
        for name, column in true.columns.items()
        if not name.startswith("gyro")
    }
    recording = replace(true, t=true.t[behind], columns=columns)
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    found = module.far_clock(problem)
    assert found.apart
    # It is named to two digits.
    assert found.late == pytest.approx(late, abs=0.05)
