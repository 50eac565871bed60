"""How large what acts is, and whether it may be so large, by made-up equations."""

from typing import NamedTuple

import numpy as np
import pytest
from small_problems import small_problem, small_recording, small_robot

from orbident.environment.agents import FREE
from orbident.estimation.output_error.disturbance_sizes import (
    identified,
    of_no_robot,
    size_of,
    surprise_of,
    widened_by,
)
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.solution import OUTSIDE, End, Linear, Prior, Solution, Unknowns

SIZES = {"slow_torque": 2e-3, "pull": 5e-4}
"""SI; the first is the size of its mean, the constant torque, too."""

DRAWS = 200


class MadeUp(NamedTuple):
    """Sensors show `H x` and noise; `x` is `beta` and what acts."""

    problem: Problem
    std: np.ndarray
    """Of all unknowns beforehand."""
    H: np.ndarray

    def drawn(self, random: np.random.Generator, assumed: np.ndarray) -> Solution:
        """The estimate with other deviations beforehand than those that are drawn."""
        x = self.std * random.standard_normal(self.std.size)
        y = self.H @ x + random.standard_normal(len(self.H))
        C = np.linalg.inv(self.H.T @ self.H + np.diag(assumed**-2.0))
        found = C @ self.H.T @ y
        left = np.column_stack([self.H, y - self.H @ found])
        places = np.array([each.place for each in self.problem.expected])
        state = Unknowns(np.zeros((1, 4)), np.zeros((1, 9)), found, places)
        linear = Linear(
            np.asarray(np.linalg.qr(left, mode="r")),
            np.zeros((0, 0, 1)),
            0.0,
            {},
            state,
        )
        end = End(np.zeros((0, found.size)), np.zeros((0, 0)))
        prior = Prior(np.zeros(found.size), assumed)
        return Solution(state, linear, end, prior, {}, True, 0.0)


@pytest.fixture(scope="module")
def made_up() -> MadeUp:
    """Some numbers of what acts are known well, and some hardly."""
    small = small_problem(small_robot(), small_recording(small_robot()))
    acting = small.problem.acting.allowing(SIZES)
    problem = small.problem._replace(acting=acting)
    sizes = np.array([each.std for each in problem.expected])
    std = np.concatenate([np.ones(OUTSIDE + small.beta.size), sizes])
    random = np.random.default_rng(5)
    rows = 3 * std.size
    told = 10.0 ** random.uniform(-2.0, 1.0, std.size) / std / np.sqrt(rows)
    return MadeUp(problem, std, told * random.standard_normal((rows, std.size)))


def free(made_up: MadeUp, *families: str) -> MadeUp:
    acting = made_up.problem.acting.allowing({each: np.inf for each in families})
    return made_up._replace(problem=made_up.problem._replace(acting=acting))


@pytest.mark.parametrize("family", ["slow_torque", "pull"])
def test_a_surprise_is_chi_square_where_all_is_as_it_may_be(
    made_up: MadeUp, family: str
):
    random = np.random.default_rng(1)
    found = [
        surprise_of(made_up.problem, made_up.drawn(random, made_up.std), family)
        for _ in range(DRAWS)
    ]
    (dof,) = {each.dof for each in found}
    # Its variance is twice its mean; three deviations of the mean of all draws.
    mean = np.mean([each.value for each in found])
    assert abs(mean - dof) < 3 * np.sqrt(2 * dof / DRAWS)


def test_what_is_larger_than_it_may_be_is_a_surprise(made_up: MadeUp):
    random = np.random.default_rng(2)
    pulls = np.array([x.family == "pull" for x in made_up.problem.expected])
    (where,) = np.nonzero(pulls)
    std = made_up.std.copy()
    std[where - len(made_up.problem.expected)] *= 100
    H = made_up.H.copy()
    H[:, where - len(made_up.problem.expected)] = 0.0
    rows = np.arange(where.size)
    H[rows, where - len(made_up.problem.expected)] = 3.0 / SIZES["pull"]
    found = made_up._replace(std=std, H=H).drawn(random, made_up.std)
    assert surprise_of(made_up.problem, found, "pull").p < 1e-4


@pytest.mark.slow
def test_the_most_likely_size_is_that_drawn(made_up: MadeUp):
    """All numbers are known to a tenth of their size, by equations of their own."""
    random = np.random.default_rng(3)
    H = np.eye(made_up.std.size + 1, made_up.std.size) * 10.0 / made_up.std
    freed = free(made_up, "slow_torque")._replace(H=H)
    acts = len(freed.problem.expected)
    sizes = [each.std for each in freed.problem.expected]
    assumed = np.concatenate([made_up.std[:-acts], sizes])
    assert np.max(assumed) == FREE
    found = [
        size_of(freed.problem, freed.drawn(random, assumed), "slow_torque")
        for _ in range(DRAWS)
    ]
    n = sum(each.family == "slow_torque" for each in freed.problem.expected)
    # A deviation's logarithm is known to `1 / sqrt(2 n)` by `n` numbers, and is
    # `1 / (2 n)` too small in the mean; three deviations of the mean of all draws.
    off = np.mean(np.log(np.array(found) / SIZES["slow_torque"]))
    assert abs(off) < 3 / np.sqrt(2 * n * DRAWS) + 1 / (2 * n)


def test_what_did_not_move_from_zero_is_smaller_than_its_deviation(made_up: MadeUp):
    """A search that ends where it began has found no number."""
    freed = free(made_up, "slow_torque")
    solution = freed.drawn(np.random.default_rng(7), made_up.std)
    state = solution.state
    state = state._replace(common=np.zeros_like(state.common))
    size = size_of(freed.problem, solution._replace(state=state), "slow_torque")
    assert 0.0 < size < SIZES["slow_torque"]


def test_how_much_narrower_deviations_would_be(made_up: MadeUp):
    """If nothing acted: by the equations without it."""
    solution = made_up.drawn(np.random.default_rng(4), made_up.std)
    acts = len(made_up.problem.expected)
    beta = slice(OUTSIDE, made_up.std.size - acts)
    without = np.linalg.inv(
        made_up.H[:, :-acts].T @ made_up.H[:, :-acts]
        + np.diag(made_up.std[:-acts] ** -2.0)
    )
    ratio = np.diag(solution.covariance)[beta] / np.diag(without)[beta]
    expected = np.exp(np.mean(np.log(ratio)) / 2)
    assert widened_by(made_up.problem.expected, solution) == pytest.approx(expected)
    assert expected > 1.0
    assert widened_by((), solution) == 1.0


def test_what_may_be_anything_and_what_is_unexpected_is_listed(made_up: MadeUp):
    """Else what is beyond chance only."""
    still = made_up._replace(std=1e-6 * made_up.std)
    solution = still.drawn(np.random.default_rng(6), made_up.std)
    assert not identified(made_up.problem, solution, {}, ())
    found = identified(made_up.problem, solution, {}, ("pull",))
    assert {fit.group for fit in found.values()} == {"pull"}
    freed = free(made_up, "pull")
    found = identified(freed.problem, solution, {}, ())
    assert {fit.group for fit in found.values()} == {"pull"}
    solution = made_up.drawn(np.random.default_rng(6), made_up.std)
    found = identified(made_up.problem, solution, {}, ())
    assert "slow_torque" in {fit.group for fit in found.values()}


@pytest.mark.parametrize("times", [-0.2, 0.03, 0.5, 1.0, 2.0, 4.0])
def test_a_mass_that_no_cad_explains_is_of_no_robot(times: float):
    """Only if it is ten deviations beyond a third of, or three times, the CAD mass."""
    assert of_no_robot(times, 1e-3, 1.0) == (not 1 / 3 < times < 3)
    assert not of_no_robot(times, 1.0, 1.0)
