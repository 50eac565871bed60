import numpy as np
import pytest
from scipy.optimize import minimize

from orbident.excitation.descent import descend
from orbident.excitation.polytope import Polytope


def box(joints: int = 2, m: int = 3) -> Polytope:
    """Every coordinate between -1 and 1."""
    normals = np.concatenate([np.eye(m), -np.eye(m)])
    return Polytope(np.repeat(normals[None], joints, axis=0), np.ones((joints, 2 * m)))


class Bowl:
    """A convex function with its minimum outside the box."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        root = random.standard_normal((6, 6))
        self.Q = root @ root.T + np.eye(6)
        self.centre = 1.5 * random.standard_normal(6)
        self.calls = 0

    def value(self, x: np.ndarray) -> float:
        off = x - self.centre
        return float(off @ self.Q @ off / 2 + 0.1 * (off**4).sum())

    def gradient(self, x: np.ndarray) -> np.ndarray:
        off = x - self.centre
        return self.Q @ off + 0.4 * off**3

    def __call__(self, y, p, mu):
        self.calls += 1
        x = y.ravel()
        return self.value(x), self.value(x), self.gradient(x).reshape(y.shape)


@pytest.mark.parametrize("seed", range(5))
def test_finds_what_slsqp_finds(seed):
    bowl = Bowl(seed)
    found = descend(bowl, box(), np.zeros((2, 3)), lambda: False)
    theirs = minimize(
        bowl.value,
        np.zeros(6),
        jac=bowl.gradient,
        bounds=[(-1, 1)] * 6,
        method="SLSQP",
        options={"ftol": 1e-12},
    )
    # The barrier's gap: at most mu = 1e-5 for each of twelve rows.
    assert theirs.fun <= found.value <= theirs.fun + 2e-4
    assert found.evaluations == bowl.calls


def test_stays_inside():
    seen = []
    bowl, polytope = Bowl(0), box()

    def watched(y, p, mu):
        seen.append(polytope.slack(y).min())
        return bowl(y, p, mu)

    descend(watched, polytope, np.zeros((2, 3)), lambda: False)
    assert min(seen) > 0


def test_stops_when_told():
    bowl = Bowl(0)
    start = np.full((2, 3), 0.1)
    found = descend(bowl, box(), start, lambda: True)
    # One evaluation a stage.
    assert found.evaluations == 4
    np.testing.assert_array_equal(found.y, start)
