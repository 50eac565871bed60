import numpy as np
import pytest

from orbident.excitation.extremes import NODES, Derivatives, extremes_of
from orbident.trajectories.trajectory import Trajectory


def random_trajectory(seed: int, harmonics: int = 5) -> Trajectory:
    random = np.random.default_rng(seed)
    joints = ("one", "two", "three")
    a, b = random.standard_normal((2, 3, harmonics))
    start, end = 0.3 * random.standard_normal((2, 3, 3))
    return Trajectory(30.0, joints, a, b, start, end)


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_eq_41(seed):
    trajectory = random_trajectory(seed)
    t = np.linspace(0.0, 30.0, 500)
    for ours, theirs in zip(
        Derivatives(trajectory).at(t), trajectory.at(t), strict=True
    ):
        # Sums of some ten terms of the order of ten.
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", [3, 4, 5, 6, 7])
def test_higher_derivatives_by_differences(order):
    derivatives, step = Derivatives(random_trajectory(0)), 1e-4
    t = np.linspace(1.0, 29.0, 50)
    below = [derivatives.of_order(order - 1, t + s) for s in (-step, step)]
    difference = (below[1] - below[0]) / (2 * step)
    found = derivatives.of_order(order, t)
    # Truncation step^2 w^2, with w = 1 rad/s; rounding 1e-16 / step.
    np.testing.assert_allclose(
        found, difference, rtol=0, atol=1e-7 * np.abs(found).max()
    )


@pytest.mark.parametrize("seed", range(5))
def test_extremes_hold_between_nodes_and_are_tight(seed):
    trajectory = random_trajectory(seed)
    found = extremes_of(trajectory)
    t = np.linspace(0.0, 30.0, 100 * NODES + 1)
    q, qd, qdd = Derivatives(trajectory).at(t)
    assert (found.position[:, 0] <= q.min(axis=0)).all()
    assert (found.position[:, 1] >= q.max(axis=0)).all()
    assert (found.velocity >= np.abs(qd).max(axis=0)).all()
    assert (found.acceleration >= np.abs(qdd).max(axis=0)).all()
    # h^2/8 of derivatives of the order of w^2 = 1: 7e-6, of extremes above one.
    np.testing.assert_allclose(found.velocity, np.abs(qd).max(axis=0), rtol=1e-4)
    np.testing.assert_allclose(found.acceleration, np.abs(qdd).max(axis=0), rtol=1e-4)
