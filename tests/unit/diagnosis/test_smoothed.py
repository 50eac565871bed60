"""Poses that come out of a smoother, told by how little neighbours differ."""

import numpy as np
import pytest
from cause_problems import problem_with

from orbident.diagnosis.filters import smoothed


def test_samples_as_noisy_as_declared_are_not_smoothed():
    assert [*smoothed(problem_with())] == []


@pytest.mark.parametrize("rows", [5, 7])
def test_a_moving_mean_is_named_with_its_length(rows: int):
    """The mean of that many samples around each (NumPy's convolution)."""

    def mean(x: np.ndarray) -> np.ndarray:
        padded = np.pad(x, rows // 2, mode="edge")
        return np.convolve(padded, np.full(rows, 1 / rows), "valid")

    problem = problem_with({f"position.{axis}": mean for axis in "xyz"})
    (found,) = smoothed(problem)
    t = problem.recording.t
    over = float(found.cause.split("over some ")[1].split(" s")[0])
    assert over == pytest.approx(rows * (t[1] - t[0]), rel=0.2)
    assert "smooths the samples of the position" in found.cause
