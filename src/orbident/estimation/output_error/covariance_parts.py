"""What each source of errors has of the covariance of `beta` (`budget.py`).

Whitened equations `A x = b + e`, of `e` with unit variances, have of the covariance

    C A'A C

and of its part about `beta` that is `(A X)' (A X)`, with the columns `X` of `C` that
belong to `beta`. All equations there are: the rows of sensors, those by which attitude
and biases go on from one interval to the next, and what is known beforehand.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import NOISE
from orbident.estimation.base_parameters import BetaEstimate, hidden_of
from orbident.estimation.budget import ErrorSource, ErrorSources, Kind
from orbident.estimation.output_error.noise_as_motion import NoiseAsMotion
from orbident.estimation.output_error.problem import Problem, by_interval, linear
from orbident.estimation.output_error.sensors import (
    TORQUES,
    TRACKERS,
    lasting_parts,
    parts_of_boundaries,
)
from orbident.estimation.solution import OUTSIDE, Prior, Solution
from orbident.threads import one_blas_thread

AS_ADDED = ("gyro", "attitude", "position", "velocity", "accelerometer")
"""The order of a sample's rows in an interval's equations; each has three axes."""

GOING_ON = ("between samples", "gyro drift", "accelerometer drift")
"""What moves the attitude, and the biases, three axes each. Between samples the base
turns by what splines of joints and wheels leave, and by the noise of wheel speeds."""


@one_blas_thread
def covariance_parts(problem: Problem, solution: Solution) -> ErrorSources:
    """The covariance of `beta` at a solution, by the sources of its errors.

    Args:
        problem: a recording's equations.
        solution: of these.
    """
    prior, here = solution.prior, solution.linear
    if here.given_up:
        here = linear(problem, solution.weights, here.at)
    # Errors of samples are times the gain, also where errors of paths count.
    C = NoiseAsMotion(problem, solution).gain.covariance[here.local :, here.local :]
    beta = np.arange(OUTSIDE, OUTSIDE + here.at.beta.size)
    X = C[:, beta]
    # Unknowns of boundaries follow those in common, without errors of their own.
    still = here._replace(factor=here.factor.copy(), links=here.links.copy())
    still.factor[:, -1], still.links[:, :, -1] = 0.0, 0.0
    z = np.stack([still.step(column) for column in X.T], axis=-1)

    def known(which: Sequence[int]) -> Float[np.ndarray, "beta beta"]:
        """`C - C_k C_kk^-1 C_k'`, with unknowns `k` in their deviations."""
        std = np.sqrt(np.diag(C)[which])
        inverse = np.linalg.pinv(C[np.ix_(which, which)] / np.outer(std, std))
        shared = X[which] / std[:, None]
        return X[beta] - shared.T @ inverse @ shared

    parts = {
        name: ErrorSource("recording" if name in GOING_ON else "noise", part)
        for name, part in _of_intervals(problem, solution, z, X).items()
        if part.any()
    }
    before = X / prior.std[:, None]
    for name, (kind, which) in _families(problem, solution).items():
        parts[name] = ErrorSource(kind, _squared(before[which]), known(which))
    parts["nominal values"] = ErrorSource("other", _squared(before[beta]))
    for name, (kind, equations) in _given(prior).items():
        A = equations[:, :-1]
        parts[name] = ErrorSource(kind, _squared(A @ X[: A.shape[1]]))
    return parts


def _given(
    prior: Prior,
) -> Mapping[str, tuple[Kind, Float[np.ndarray, "rows columns"]]]:
    """Equations that hold beforehand, by their names."""
    every: dict[str, tuple[Kind, Float[np.ndarray, "rows columns"]]] = {
        "other recordings": ("recording", prior.others),
        "measured before": ("other", prior.measured),
        "what swings": ("other", prior.carried),
    }
    return {name: each for name, each in every.items() if len(each[1])}


def _squared(rows: Float[np.ndarray, "rows beta"]) -> Float[np.ndarray, "beta beta"]:
    return rows.T @ rows


def _of_intervals(
    problem: Problem,
    solution: Solution,
    z: Float[np.ndarray, "boundaries local beta"],
    X: Float[np.ndarray, "common beta"],
) -> dict[str, Float[np.ndarray, "beta beta"]]:
    """The parts of sensors, and of what goes on from interval to interval.

    That weighs so much that `z` must be of the same state as the equations.
    """
    names = (*AS_ADDED, TORQUES, "joints", *GOING_ON)
    weights, size = solution.weights, problem.t.size
    none = np.zeros((size, 3))
    counts = np.hstack([weights.get(name, none) != 0 for name in AS_ADDED])
    torques = np.count_nonzero(weights.get(TORQUES, none), axis=1)
    of_trackers = [names.index(name) for name in TRACKERS]
    trackers, own = (
        np.repeat(of_trackers, parts(problem.lasting).sum(axis=(1, 2)))
        for parts in (lasting_parts, parts_of_boundaries)
    )
    going_on = np.repeat([names.index(name) for name in GOING_ON], 3)
    joints = names.index("joints")
    parts = np.zeros((len(names), X.shape[1], X.shape[1]))

    def add(rows: np.ndarray, sources: np.ndarray) -> None:
        for k in np.unique(sources):
            parts[k] += _squared(rows[sources == k])

    edges = [*np.searchsorted(problem.t, problem.boundaries[:-1]), size]
    every = by_interval(problem, weights, solution.linear.at)
    for k, equations in enumerate(every):
        _, columns = np.nonzero(counts[edges[k] : edges[k + 1]])
        rows = equations[:, :-1] @ np.vstack([z[k], z[k + 1], X])
        of_torques = np.full(torques[edges[k]], names.index(TORQUES))
        before = np.concatenate([columns // 3, trackers, of_torques, going_on])
        # Then passive joints, and encoders.
        add(rows, np.append(before, np.full(len(rows) - before.size, joints)))
    of_joints = np.full(z.shape[1] - going_on.size - own.size, joints)
    first = z[0] / problem.loose.first[:, None]
    add(first, np.concatenate([going_on, own, of_joints]))
    return dict(zip(names, parts, strict=True))


def _families(
    problem: Problem, solution: Solution
) -> Mapping[str, tuple[Kind, Sequence[int]]]:
    """The common unknowns beside `beta`, by family."""
    selected = solution.state.selected
    own = {each.place for each in problem.instruments}
    # To work out what may act takes some 3 kB a row.
    acting = () if {*selected} <= own else problem.acting.unknowns
    by_place = {each.place: each.family for each in (*problem.instruments, *acting)}
    families: dict[str, tuple[Kind, list[int]]] = {
        "initial momentum": ("recording", [*range(OUTSIDE)])
    }
    first = solution.state.common.size - selected.size
    for k, place in enumerate(selected.tolist(), first):
        kind: Kind = "instrument" if place in own else "recording"
        name = by_place[place]
        families.setdefault(name, ("noise" if name == NOISE else kind, []))[1].append(k)
    return families


def estimate_of(solution: Solution, scale: Float[np.ndarray, " beta"]) -> BetaEstimate:
    """The part of a solution that is about `beta`."""
    n, prior, state = scale.size, solution.prior, solution.state
    of_beta = slice(OUTSIDE, OUTSIDE + n)
    # What is known beforehand of all else counts: a momentum gives the scale.
    std = prior.std.copy()
    std[of_beta] = np.inf
    factor = prior._replace(std=std).added(solution.linear.common, state)
    if state.selected.size:
        # With the calibrations first, the last rows are what is known of beta alone.
        columns = np.roll(np.arange(OUTSIDE, len(factor) - 1), state.selected.size)
        order = np.r_[:OUTSIDE, columns, len(factor) - 1]
        factor = np.asarray(np.linalg.qr(factor[:, order], mode="r"))
    C = solution.covariance[solution.linear.local :, solution.linear.local :]
    return BetaEstimate(
        values=state.beta,
        covariance=C[of_beta, of_beta],
        hidden=hidden_of(factor[-n - 1 : -1, -n - 1 : -1], scale),
    )
