"""One recording from a real table, read in three ways."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.found import EstimatedParameters, found_beta
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.maximum_likelihood import estimate_of
from orbident.estimation.momentum_problem import momentum_problems
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.prior_std import prior_std
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.estimation.solve import solve
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.studies.filters import Filters
from orbident.studies.mocap_method import from_mocap
from orbident.studies.planar_run import Table6

PAPER, WITHOUT, WITH = "paper", "without", "with"


class TableReading(NamedTuple):
    """Table 6's parameters as one way of reading has them, `M` last."""

    values: Float[np.ndarray, " parameters"]
    std: Float[np.ndarray, " parameters"]

    @classmethod
    def of(
        cls, found: EstimatedParameters, M: tuple[float, float], table: Table6
    ) -> "TableReading":
        """The found sets in the basis of the table."""
        pi, phi = table.basis.pi(found.pi.values), table.basis.phi(found.phi.values)
        C_pi = table.basis.pi_of_pi @ found.pi.covariance @ table.basis.pi_of_pi.T
        C_phi = table.basis.phi_of_phi @ found.phi.covariance @ table.basis.phi_of_phi.T
        variances = np.concatenate([np.diag(C_pi), np.diag(C_phi)])
        return cls(np.array([*pi, *phi, M[0]]), np.array([*np.sqrt(variances), M[1]]))


class TableRun(NamedTuple):
    """One seed."""

    recording: Recording
    readings: dict[str, TableReading]
    """The parameters that each way of reading has: `paper`, `without` and `with`."""
    result: Result
    """The result of maximum likelihood that looks for what acts."""
    refused: str
    """Why the paper's method refuses its result; empty where it does not."""


def read_table(
    robot: Robot, flight: Recording, table: Table6, filters: Filters
) -> TableRun:
    """Read a recording by the paper's method, and by maximum likelihood twice.

    Args:
        robot: `table_robot`.
        flight: as its sensors recorded it, from rest.
        table: of Table 6.
        filters: of the paper's method.
    """
    paper, paper_result = _by_paper(robot, from_mocap(robot, flight, filters))
    solved = solve(robot, flight, "at-rest", OutputError(), lambda _: None)
    estimate, sets = solved.estimate, solved.problem.sets
    # The same search, before anything from outside is among the unknowns.
    assert estimate.solution is not None
    plain = estimate_of(estimate.solution, prior_std(robot, sets))
    readings = {
        PAPER: _reading(paper, table),
        WITHOUT: TableReading.of(found_beta(robot, sets, plain), plain.mass, table),
        WITH: _reading(estimate, table),
    }
    result = _judged(solved, "maximum-likelihood")
    rejected = paper_result.status == "rejected"
    return TableRun(
        flight, readings, result, paper_result.warnings[0] if rejected else ""
    )


def _by_paper(robot: Robot, recording: Recording) -> tuple[Estimate, Result]:
    """The linear fits of filtered signals, and what is thought of them."""
    problem, *_ = momentum_problems(robot, recording, "at-rest", lambda _: None)
    estimate = LeastSquares().estimate(problem, lambda _: None)
    solved = Solved(problem, obstacles(problem), estimate, None)
    return estimate, _judged(solved, "least-squares")


def _judged(solved: Solved, name: str) -> Result:
    masses = dict(solved.estimate.masses)
    judgement = judge(solved, masses)
    return result_of(
        solved.problem, name, solved.estimate, judgement, masses, None, 0.0
    )


def _reading(estimate: Estimate, table: Table6) -> TableReading:
    M = estimate.mass.value, estimate.mass.std
    return TableReading.of(estimate.found, M, table)
