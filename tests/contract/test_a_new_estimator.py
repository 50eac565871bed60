"""A fifth method is one small class, judged by the same criteria."""

from dataclasses import dataclass, replace

import numpy as np

from orbident.estimation.base_parameters import beta_of_fits
from orbident.estimation.estimate import Estimate, Progress, estimate_of_beta
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


@dataclass(frozen=True)
class WhiteNoise:
    """The base parameters from both linear fits, as if all noise were white."""

    name: str = "white-noise"
    converged: bool = True

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        beta = beta_of_fits(problem.robot, problem.sets, problem.fits)
        progress(1.0)
        estimate = estimate_of_beta(problem, beta, self.name, {}, None)
        return replace(estimate, converged=self.converged)


def test_it_identifies(robot: Robot, recording: Recording):
    result = identify(robot, recording, WhiteNoise())
    assert result.method == "white-noise"
    assert result.level == "trust"
    beta = minimal_sets(robot).beta(robot.theta)
    np.testing.assert_allclose(result.base.values, beta, atol=1e-9 * abs(beta).max())


def test_it_is_refused_like_the_others(robot: Robot, recording: Recording):
    result = identify(robot, recording, WhiteNoise(converged=False))
    assert result.level == "do not trust"
    assert [check.name for check in result.checks if not check.passed] == [
        "convergence"
    ]
    assert np.isnan(result.base.values).all()
    assert result.diagnostics is not None
    assert np.isfinite(result.diagnostics.base.values).all()
