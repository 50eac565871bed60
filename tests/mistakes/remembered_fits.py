"""The sensors of a recording are fitted once, for all methods that are judged by it."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from orbident.estimation.estimate import Estimate, Progress
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.estimator import OutputError


@contextmanager
def fits_remembered() -> Iterator[None]:
    """Remember fits by output error while other methods identify the recording.

    All methods make the same problem of it, but for its clocks and a push.
    """
    fit = OutputError.estimate
    # With the problem: a robot that is gone leaves its `id` to another one.
    known = dict[tuple, tuple[MomentumProblem, Estimate]]()

    def remembered(
        self: OutputError, problem: MomentumProblem, progress: Progress
    ) -> Estimate:
        recording = problem.recording
        columns = {name: x.tobytes() for name, x in recording.columns.items()}
        key = (
            self.steps,
            self.tested,
            tuple(sorted(self.free.items())),
            id(problem.robot),
            problem.initial_momentum,
            problem.samples.pushed,
            recording.t.tobytes(),
            tuple(sorted(columns.items())),
            tuple(sorted(problem.late.items())),
        )
        if key not in known:
            known[key] = problem, fit(self, problem, progress)
        return known[key][1]

    with patch.object(OutputError, "estimate", remembered):
        yield
