"""Sample by sample, with a watch for changes of the robot."""

from dataclasses import dataclass, replace

import numpy as np

from orbident.estimation.estimate import (
    Estimate,
    Goodness,
    Progress,
    biases_of_sensors,
    estimate_of_beta,
    rms_of_equations,
)
from orbident.estimation.found import BetaEstimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursive.history import recursive_history


@dataclass(frozen=True)
class Recursive:
    """The information filter from CAD values, which it takes to be uncertain by 30 %.

    The estimate is that after the last sample.
    """

    name: str = "recursive"

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Take the samples one by one.

        Raises:
            InputError: no sample is complete.
        """
        robot, samples = problem.robot, problem.samples
        history = recursive_history(robot, samples, problem.h_cm, progress=progress)
        nothing = np.zeros((history.beta.shape[1], 0))
        last = BetaEstimate(history.beta[-1], history.covariance, nothing)
        since = history.t > (history.changes[-1].t if history.changes else -np.inf)
        goodness = Goodness(
            float(history.nis[since].sum()),
            float(history.dof[since].sum()),
            history.declared,
        )
        rms = rms_of_equations(problem)
        estimate = estimate_of_beta(problem, last, "recursion", rms, goodness)
        base = estimate.found.base
        learnt = base._replace(determined=base.determined & history.determined)
        return replace(
            estimate,
            found=estimate.found._replace(base=learnt),
            biases=biases_of_sensors(problem, history.biases),
            history=history,
        )
