"""Joints with torques in one step of the filter, by energies and differences.

A joint's momentum is how the energy changes with its rate, and its slope how it changes
with its position. What a momentum gains is taken out of the rows of the nuisances by a
matrix over all unknowns, and what nothing is known of is eliminated.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from obvious_momentum import body_motion
from reference.filter_step import Axes, inertia, robots_that_determine, spread

from orbident.estimation.recursive.filter import Sample, State
from orbident.estimation.recursive.filter_input import Noise
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

ANY = 1e3
"""N m s: the deviation of a momentum of which nothing is known."""

STEP = 1e-3
"""Step of central differences with an error of its fourth power."""


class Driven(NamedTuple):
    """A row of the filter's table."""

    joint: int
    walk: float
    still: float
    known: np.ndarray
    std: np.ndarray


def driven_of(noise: Noise) -> list[Driven]:
    return [
        Driven(int(row[0]), row[1], row[2], row[3:8], row[8:])
        for row in noise.driven.table
    ]


def energy(robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> float:
    """Kinetic, about the system CM, wheels apart."""
    twice, linear = 0.0, np.zeros(3)
    for i, (m, mx, my, mz, xx, xy, yy, xz, yz, zz) in enumerate(robot.theta):
        body = body_motion(robot, i, q, qd, w)
        s = body.R @ np.array([mx, my, mz])
        I = body.R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ body.R.T
        p = m * body.v + np.cross(body.w, s)
        twice += body.v @ p + body.w @ (np.cross(s, body.v) + I @ body.w)
        linear += p
    return float(twice - linear @ linear / robot.mass) / 2


def momentum(
    robot: Robot, k: int, q: np.ndarray, qd: np.ndarray, w: np.ndarray
) -> float:
    """Energy is of second order in the rates."""
    e = np.eye(q.size)[k]
    return (energy(robot, q, qd + e, w) - energy(robot, q, qd - e, w)) / 2


def slope(robot: Robot, k: int, q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> float:
    e = STEP * np.eye(q.size)[k]
    one, two = (
        energy(robot, q + i * e, qd, w) - energy(robot, q - i * e, qd, w)
        for i in (1, 2)
    )
    return (8 * one - two) / (12 * STEP)


Quantity = Callable[[Robot, int, np.ndarray, np.ndarray, np.ndarray], float]


def row_of(
    robot: Robot, noise: Noise, state: State, sample: Sample, k: int, of: Quantity
):
    """What each unknown adds to a momentum or a slope at the gyro's rate less bias."""
    sets = minimal_sets(robot)
    axes = np.array(sets.regressors.momentum_axes)
    w = np.array(sample.w)
    w[axes] = sample.w_smooth[axes]
    thetas = robots_that_determine(robot, sets)
    values = [of(replace(robot, theta=x), k, sample.q, sample.qd, w) for x in thetas]
    pis = np.array([sets.pi(x) for x in thetas])
    found = np.linalg.lstsq(pis, np.array(values), rcond=None)[0]
    scale = np.abs(values).max()
    np.testing.assert_allclose(pis @ found, values, atol=1e-8 * scale)
    theta = (sets.base.theta_of @ state.beta).reshape(-1, 10)
    at_beta = replace(robot, theta=theta)
    by_rate = [
        (
            of(at_beta, k, sample.q, sample.qd, w + e)
            - of(at_beta, k, sample.q, sample.qd, w - e)
        )
        / 2
        for e in np.eye(3)[axes]
    ]
    n, y = len(state.top), len(state.R_z)
    row = np.zeros(n + y + 1)
    row[n : n + pis.shape[1]] = found
    bias = axes.size + len(sets.regressors.velocity_axes) + len(noise.driven.table)
    row[bias : bias + axes.size] = np.negative(by_rate)
    return row


def follows(noise: Noise, own: Driven, k: int, before: Sample, now: Sample) -> bool:
    """Whether the torque says what the momentum gained between two samples."""
    rates = before.qd[own.joint], now.qd[own.joint]
    turning = min(map(abs, rates)) > own.still and rates[0] * rates[1] > 0
    known = np.isfinite(before.impulse[k] + now.impulse[k])
    return bool(known and turning and now.t - before.t <= noise.driven.longest)


def forgotten(top: np.ndarray, place: int) -> np.ndarray:
    """Rows without one of their unknowns, which is eliminated; and a weak one of it."""
    others = np.delete(np.arange(top.shape[1]), place)
    turned = np.asarray(np.linalg.qr(top[:, [place, *others]], mode="r"))
    rows = np.zeros_like(top)
    rows[:-1, others] = turned[1 : len(top), 1:]
    rows[-1, place] = 1 / ANY
    return rows


def gained(
    robot: Robot, noise: Noise, state: State, before: Sample, now: Sample, axes: Axes
) -> tuple[np.ndarray, np.ndarray]:
    """How unknowns change over a step, `[x, y, -1]` before by those after it.

    And where the momenta are of which nothing is known after it.
    """
    n, y = len(state.top), len(state.R_z)
    change, lost = np.eye(n + y + 1), list[int]()
    dt, drives = now.t - before.t, n - 5 * len(noise.driven.table)
    for k, own in enumerate(driven_of(noise)):
        place, at = axes.h.size + axes.v.size + k, drives + 5 * k
        if not follows(noise, own, k, before, now):
            lost.append(place)
            continue
        by = [row_of(robot, noise, state, x, own.joint, slope) for x in (before, now)]
        change[place] -= dt / 2 * (by[0] + by[1])
        impulse = now.impulse[k] - before.impulse[k]
        dq = now.q[own.joint] - before.q[own.joint]
        change[place, at + 1 : at + 5] += [dq, np.sign(dq) * dt, dt, impulse]
        change[place, -1] += impulse
    return change, np.array(lost, dtype=int)


def momentum_rows(
    robot: Robot, noise: Noise, state: State, sample: Sample, axes: Axes
) -> np.ndarray:
    """The rows of the joints' momenta, whitened."""
    n, rows = len(state.top), []
    theta = (minimal_sets(robot).base.theta_of @ state.beta).reshape(-1, 10)
    at_beta = replace(robot, theta=theta)
    D_q = inertia(at_beta, sample.q)[1]
    still, drives = np.zeros(3), n - 5 * len(noise.driven.table)
    excess = spread((sample.w - sample.w_smooth)[axes.h], axes.h)
    for k, own in enumerate(driven_of(noise)):
        if not np.isfinite(sample.impulse[k]):
            continue
        row = row_of(robot, noise, state, sample, own.joint, momentum)
        row[axes.h.size + axes.v.size + k] = -1.0
        row[drives + 5 * k] = sample.qd[own.joint]
        row[-1] -= D_q[:, own.joint] @ excess
        D_qq = np.array(
            [
                momentum(at_beta, own.joint, sample.q, e, still)
                for e in np.eye(sample.q.size)
            ]
        )
        D_qq[own.joint] += own.known[0]
        of_rates = noise.gyro * D_q[axes.h, own.joint], noise.joint_rates * D_qq
        rows.append(row / np.linalg.norm(np.concatenate(of_rates)))
    return np.reshape(rows, (-1, n + len(state.R_z) + 1))
