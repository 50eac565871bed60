"""A Kalman smoother (Rauch, Tung, Striebel 1965) in blocks: little memory."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from orbident.compilation import compiled
from orbident.dynamics.batches import BATCH
from orbident.spatial.arrays import AnyArray


class Model(NamedTuple):
    """`z_{k+1} = F_k z_k + N(0, diag Q_k)`; the first state is `N(0, diag before)`."""

    F: Float[AnyArray, "steps state state"]
    Q: Float[AnyArray, "steps state"]
    before: Float[AnyArray, " state"]


class _State(NamedTuple):
    z: Float[AnyArray, "*n state"]
    P: Float[AnyArray, "*n state state"]


class _Step(NamedTuple):
    """From the row before to this one, and what was measured here."""

    F: Float[AnyArray, "*n state state"]
    Q: Float[AnyArray, "*n state"]
    y: Float[AnyArray, "*n measured"]
    R: Float[AnyArray, "*n"]
    """Variance of each `y`; infinite where nothing was measured."""


def smoothed(
    model: Model,
    y: Float[np.ndarray, "n measured"],
    seen: Bool[np.ndarray, " n"],
    std: float,
) -> tuple[Float[np.ndarray, "n state"], Float[np.ndarray, "n state"]]:
    """Mean and variance of the state at every row, given all measurements.

    Args:
        model: of the state.
        y: the first components of the state, with noise `N(0, std^2)`.
        seen: rows on which `y` was measured.
        std: in the unit of `y`.
    """
    n, size = y.shape[0], model.before.size
    blocks = n // BATCH + 1
    # Rows of padding, at least one, at which nothing changes and nothing is seen.
    steps = _Step(
        F=_padded(np.eye(size), model.F, 1, blocks),
        Q=_padded(np.zeros(size), model.Q, 1, blocks),
        y=_padded(np.zeros(y.shape[1]), np.where(seen[:, None], y, 0.0), 0, blocks),
        R=_padded(np.inf, np.where(seen, std**2, np.inf), 0, blocks),
    )
    state = _State(np.zeros(size), np.diag(model.before))
    starts = []
    for k in range(blocks):
        starts.append(state)
        filtered = _forward(state, _rows(steps, k, 0))
        state = _State(filtered.z[-1], filtered.P[-1])
    mean, variance = np.empty((n, size)), np.empty((n, size))
    for k in reversed(range(blocks)):
        filtered = _forward(starts[k], _rows(steps, k, 0))
        found = _backward(state, filtered, _rows(steps, k, 1))
        state = _State(found.z[0], found.P[0])
        rows = np.s_[k * BATCH : min((k + 1) * BATCH, n)]
        count = rows.stop - rows.start
        mean[rows] = found.z[:count]
        variance[rows] = np.diagonal(found.P, axis1=1, axis2=2)[:count]
    return mean, variance


def _padded(
    value: np.ndarray | float, rows: AnyArray, before: int, blocks: int
) -> np.ndarray:
    """Rows of `value` before and after, to one more than the blocks hold."""
    table = np.empty((blocks * BATCH + 1, *rows.shape[1:]))
    table[:] = value
    table[before : before + len(rows)] = rows
    return table


def _rows(steps: _Step, block: int, ahead: int) -> _Step:
    start = block * BATCH + ahead
    return _Step(*(part[start : start + BATCH] for part in steps))


@compiled
def _forward(state: _State, steps: _Step) -> _State:
    """The filter: state and covariance at each row, given all up to it."""

    def step(state: _State, now: _Step) -> tuple[_State, _State]:
        z, P = _predicted(state, now)
        measured = now.y.size
        H = jnp.eye(measured, z.size)
        # As 1/R, which is zero where nothing was seen: K = P H^T S^-1.
        S = P[:measured, :measured] / now.R + jnp.eye(measured)
        K = jnp.linalg.solve(S.T, P[:, :measured].T / now.R).T
        z = z + K @ (now.y - z[:measured])
        # Joseph: P stays symmetric and positive.
        A = jnp.eye(z.size) - K @ H
        noise = jnp.where(jnp.isfinite(now.R), now.R, 0.0)
        state = _State(z, A @ P @ A.T + noise * K @ K.T)
        return state, state

    return jax.lax.scan(step, state, steps)[1]


@compiled
def _backward(after: _State, filtered: _State, following: _Step) -> _State:
    """The smoother: the same given all; `following` are the steps to the next rows."""

    def step(after: _State, row: tuple[_State, _Step]) -> tuple[_State, _State]:
        here, to = row
        z, P = _predicted(here, to)
        C = jnp.linalg.solve(P, to.F @ here.P).T
        P_smoothed = here.P + C @ (after.P - P) @ C.T
        state = _State(here.z + C @ (after.z - z), (P_smoothed + P_smoothed.T) / 2)
        return state, state

    return jax.lax.scan(step, after, (filtered, following), reverse=True)[1]


def _predicted(state: _State, step: _Step) -> _State:
    Q = jnp.diag(step.Q)
    return _State(step.F @ state.z, step.F @ state.P @ step.F.T + Q)
