"""Maximum likelihood as an estimator like the others."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.estimation.estimate import Estimate, Progress, estimate_of_beta
from orbident.estimation.maximum_likelihood import maximum_likelihood
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.nonlinear_fit import beta_of_fits
from orbident.estimation.output_error.solver import STEPS
from orbident.estimation.shared import Shared

FEW_STEPS = 12
"""Steps of a search that tries an amendment: where it is right, fewer are needed."""


@dataclass(frozen=True)
class OutputError:
    """Maximum likelihood of all that the sensors showed, by output error."""

    name: str = "maximum-likelihood"
    steps: int = STEPS
    """The most steps that the search takes with one set of the sensors' weights."""
    others: Shared | None = None
    """What other recordings of the same robot say."""

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Fit all sensors at once."""
        done = 0.0

        def step() -> None:
            # How many steps there will be nobody knows: half of what is left.
            nonlocal done
            done += (1 - done) / 2
            progress(done)

        likelihood = maximum_likelihood(
            problem.robot,
            problem.sets,
            problem.recording,
            problem.samples,
            problem.fits,
            _first(problem),
            problem.late,
            problem.initial_momentum,
            step,
            self.steps,
            self.others,
        )
        sensors = likelihood.sensors
        rms = {name: fit.rms for name, fit in sensors.items()}
        return replace(
            estimate_of_beta(
                problem,
                likelihood.estimate,
                "maximum likelihood",
                rms,
                likelihood.goodness,
                disturbed=bool(likelihood.disturbances),
            ),
            sensors=sensors,
            biases=likelihood.biases,
            disturbances=likelihood.disturbances,
            suspected=likelihood.suspected,
            unseen=likelihood.unseen,
            instead=likelihood.instead,
            calibration=likelihood.calibration,
            sensitivity=likelihood.sensitivity,
            converged=likelihood.converged,
            settled=likelihood.settled,
            convergence=likelihood.convergence,
            signals=likelihood.signals,
            solution=likelihood.solution,
            shared=likelihood.shared,
            given=likelihood.given,
        )


def _first(problem: MomentumProblem) -> Float[np.ndarray, " beta"]:
    """A first `beta` by the linear fits; these know nothing of thrust: then by CAD."""
    if problem.samples.unknown_thrust:
        return problem.sets.beta(problem.robot.theta)
    return beta_of_fits(problem.robot, problem.sets, problem.fits).values
