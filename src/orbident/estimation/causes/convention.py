"""One way to write what others write differently, and what undoes it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from orbident.estimation.causes.shifts import with_columns
from orbident.estimation.problem import MomentumProblem
from orbident.preprocessing.samples import Samples
from orbident.recordings.recording import Recording

DEGREE = np.pi / 180


@dataclass(frozen=True)
class Convention:
    """A cause of a misfit, and what undoes it."""

    cause: str
    """What is wrong, if it is this: a clause."""
    amended: Callable[[MomentumProblem], Samples]
    columns: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """By name of a joint or wheel column: the column that replaces it, and a factor."""

    def recording(self, recording: Recording) -> Recording:
        """With its columns put right."""
        right = {
            name: factor * recording.columns[source]
            for name, (source, factor) in self.columns.items()
            if recording.has(source)
        }
        return with_columns(recording, right)


def scaled(
    names: Sequence[str], factor: float, cause: str, only: Sequence[int] = ()
) -> Convention:
    """Samples of these names times a factor, of all joints or wheels or of some."""

    def amended(problem: MomentumProblem) -> Samples:
        samples = problem.samples
        columns = {
            name: tuple(
                factor * column if not only or k in only else column
                for k, column in enumerate(getattr(samples, name))
            )
            for name in names
        }
        return replace(samples, **columns)

    return Convention(cause, amended)
