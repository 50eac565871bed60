"""The gradient of a design's criterion, beside differences of its values."""

import numpy as np
import pytest

from orbident.excitation.design_problem import DesignProblem


def check_gradient(problem: DesignProblem, step: float, rel: float) -> None:
    """Along three random directions, by Richardson's extrapolation.

    Args:
        problem: of any motion.
        step: of the finer differences.
        rel: how far both may differ, over the product of the norms.
    """
    random = np.random.default_rng(1)
    shape = len(problem.motions.coupled.free), problem.motions.basis[0].shape[1]
    y = 0.3 * random.standard_normal(shape)
    gradient = problem.evaluate(y, 8.0).gradient
    for direction in random.standard_normal((3, *shape)):

        def value(step, direction=direction):
            return problem.evaluate(y + step * direction, 8.0).smooth

        def slope(step):
            return (value(step) - value(-step)) / (2 * step)

        expected = (4 * slope(step) - slope(2 * step)) / 3
        size = float(np.linalg.norm(gradient) * np.linalg.norm(direction))
        found = float((gradient * direction).sum())
        assert found == pytest.approx(expected, abs=rel * size)
