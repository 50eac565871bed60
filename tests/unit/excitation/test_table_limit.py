"""Motions that keep S and the arm on a small table, while the base drifts and turns."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from orbident.errors import InputError
from orbident.excitation.conditions import conditions_for, limits_of
from orbident.excitation.design import design_excitation
from orbident.excitation.design_problem import problem_for
from orbident.excitation.guarantee import floated, proven
from orbident.excitation.table_points import (
    TABLE_SIZES,
    TableSize,
    centre_of,
    table_points,
)
from orbident.model.kinematics import poses


def conditions(robot, table):
    return conditions_for(robot, 20.0, 3, limits_of(robot, table=table))


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)


def momentum_conserved(robot, trajectory, t):
    """Where points are, by the momentum of three point masses that turn (closed form).

    Angular momentum about S and linear momentum are sums over the bodies; both are zero
    about the CM, and the base's rate is their solution, integrated by SciPy.
    """
    (m, s, I_zz), base = robot.theta[:, [0, 1, 9]].T, robot.theta
    s = base[:, 1:3]

    def seen(time):
        """Origins, directions and rates relative to the base, of all bodies."""
        time = np.atleast_1d(time)
        q, qd, _ = trajectory.at(time)
        angles = np.cumsum(np.pad(q, ((0, 0), (1, 0))), axis=1)
        rates = np.cumsum(np.pad(qd, ((0, 0), (1, 0))), axis=1)
        p, v = np.zeros((2, len(time), 3, 2))
        for k, joint in enumerate(robot.joints):
            arm = turned(angles[:, k]) @ joint.p_PJ[:2]
            p[:, k + 1] = p[:, k] + arm
            v[:, k + 1] = v[:, k] + rates[:, k, None] * arm @ [[0, 1], [-1, 0]]
        return p, v, angles, rates

    def cm(time):
        p, v, angles, rates = seen(time)
        first = np.stack([turned(angles[:, i]) @ s[i] for i in range(3)], axis=1)
        r = (m[:, None] * p + first).sum(axis=1) / m.sum()
        moved = rates[..., None] * first @ [[0, 1], [-1, 0]]
        rd = (m[:, None] * v + moved).sum(axis=1) / m.sum()
        return p, v, first, moved, r, rd, rates

    wheel = robot.wheels[0].inertia * trajectory.initial.wheel_speed["rw"]

    def rate(time, _):
        p, v, first, moved, r, rd, rates = cm(time)

        def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

        # About S, relative to the base; then about the CM.
        h = cross(p, m[:, None] * v + moved) + cross(first, v) + I_zz * rates
        D = m * (p**2).sum(axis=-1) + 2 * (p * first).sum(axis=-1) + I_zz
        h_cm = h.sum(axis=1) - m.sum() * cross(r, rd) + wheel
        D_cm = D.sum(axis=1) - m.sum() * (r**2).sum(axis=-1)
        return -h_cm / D_cm

    solved = solve_ivp(rate, (0.0, t[-1]), [0.0], t_eval=t, rtol=1e-10, atol=1e-10)
    p, _, first, _, r, *_ = cm(t)
    tip = p[:, 2] + 2 * first[:, 2] / m[2]
    from_cm = np.concatenate([p, tip[:, None]], axis=1) - r[:, None]
    return np.einsum("nij,npj->npi", turned(solved.y[0]), from_cm)


@pytest.fixture(scope="module")
def kept(emulator):
    return design_excitation(
        emulator, conditions=conditions(emulator, TableSize(1.0, 1.0)), starts=2
    )


@pytest.mark.slow
def test_a_motion_that_would_leave_the_table_stays_on_it(emulator, kept):
    free = design_excitation(
        emulator, conditions=conditions(emulator, TableSize()), starts=2
    )
    t = np.linspace(0.0, 20.0, 2001)
    for trajectory, stays in ((free, False), (kept, True)):
        assert trajectory.design is not None
        *needed, _ = np.array(trajectory.design["proven"]["table"])
        points = momentum_conserved(emulator, trajectory, t)
        reached = np.ptp(points, axis=(0, 1))
        assert (reached < needed).all()
        np.testing.assert_allclose(reached, needed, atol=2e-4)
        assert (np.max(needed) <= 1.0) == stays
    assert kept.design["proven"]["table_limit"] == [1.0, 1.0, None]
    motion = floated(emulator, kept)
    np.testing.assert_allclose(motion.v_cm, 0.0, atol=1e-12)
    needed = proven(emulator, kept).base.table
    assert needed == pytest.approx(kept.design["proven"]["table"])


def test_the_arm_begins_folded(emulator):
    """Stretched out it sweeps 1.3 m."""
    given = conditions(emulator, TableSize(1.0, 1.0))
    np.testing.assert_array_equal(given.start, given.end)
    (low, high), q = emulator.joints[0].position, given.start[:, 0]
    assert low < q[0] < high
    P = poses(emulator, q[None])
    tip = P.arm(2, table_points(emulator)[-1][1])
    assert np.linalg.norm(tip) < 0.45


def test_the_points(emulator):
    points = table_points(emulator)
    assert [body for body, _ in points] == [0, 1, 2, 2]
    np.testing.assert_allclose(points[-1][1], [0.1808, 0.0, 0.0], atol=1e-12)


def test_gradients_of_the_sides(emulator):
    given = replace(conditions(emulator, TableSize(1.0, 0.8, 0.5)), harmonics=2)
    drifting = replace(given.initial, velocity=np.array([0.02, -0.01, 0.0]))
    problem = problem_for(emulator, replace(given, initial=drifting), "cond", 0.1)
    assert problem.limited == TABLE_SIZES
    random = np.random.default_rng(0)
    y, step = 0.2 * random.standard_normal((2, 2, problem.motions.basis[0].shape[1]))
    e = 1e-5
    after, before = (problem.evaluate(y + x * step, 2.0).used for x in (e, -e))
    slope = np.einsum("lij,ij->l", problem.evaluate(y, 2.0).used_gradient, step)
    np.testing.assert_allclose((after - before) / (2 * e), slope, rtol=1e-4)


def test_a_round_table(emulator):
    """Every point stays in the circle, by the closed form."""
    given = conditions(emulator, TableSize(radius=0.55))
    round_one = design_excitation(emulator, conditions=given, starts=2)
    assert round_one.design is not None
    *_, radius = round_one.design["proven"]["table"]
    points = momentum_conserved(emulator, round_one, np.linspace(0.0, 20.0, 2001))
    points = points.reshape(-1, 2)
    best = minimize(
        lambda c: np.linalg.norm(points - c, axis=1).max(),
        [0.01, 0.01],
        method="Nelder-Mead",
        options={"xatol": 1e-8, "fatol": 1e-8},
    )
    assert best.fun < radius <= 0.55
    assert radius == pytest.approx(best.fun, rel=2e-3)


@pytest.mark.parametrize("points", [1, 2, 3, 40, 500])
def test_the_smallest_circle(points):
    random = np.random.default_rng(points)
    x = random.standard_normal((points, 2)) * [1.0, 0.3] + [3.0, 1.0]
    found = np.linalg.norm(x - centre_of(x, 1e5), axis=1).max()
    # At least half of the farthest two, and of an equilateral triangle 1 / sqrt 3.
    farthest = np.linalg.norm(x[:, None] - x, axis=2).max()
    assert farthest / 2 <= found + 1e-12
    assert found <= farthest / np.sqrt(3) + 1e-12
    least = minimize(
        lambda c: np.linalg.norm(x - c, axis=1).max(),
        x.mean(axis=0) + 0.01,
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-10},
    )
    assert found <= least.fun * (1 + 1e-4) + 1e-9


@pytest.mark.slow
def test_a_table_too_small_says_by_how_much(emulator):
    given = conditions(emulator, TableSize(0.3, 2.0))
    with pytest.raises(InputError, match=r"limit of table width, by .* other ends"):
        design_excitation(emulator, conditions=given, starts=1)


def test_no_table_in_space(servicer):
    with pytest.raises(InputError, match="table limit: the robot flies in space"):
        limits_of(servicer, table=TableSize(1.0, 1.0))
    with pytest.raises(InputError, match="table depth limit: found 0"):
        limits_of(servicer, table=TableSize(1.0, 0.0))
