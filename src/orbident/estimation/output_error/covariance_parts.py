"""What each source of errors has of the covariance of `beta` (`budget.py`).

With the information `S` about the common unknowns, all others eliminated,

    C F_s C = C (dS / d ln lambda_s) C

where `lambda_s` multiplies the information of sensor `s`: a linearisation a sensor. What
the sensors leave of `C S C` is the part of what drifts between samples, which is among
the eliminated: biases, and attitude by the noise of wheel speeds.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.budget import Kind, Source, Sources
from orbident.estimation.output_error.problem import Problem, common_factor
from orbident.estimation.solution import OUTSIDE, Solution

RAISED = 1e-4
"""Of a sensor's information. Information of what is left after an elimination bends so
that parts are too small by less than this, relative; rounding is a thousandth of it."""



def covariance_parts(
    problem: Problem, solution: Solution, off: Float[np.ndarray, "beta n"]
) -> Sources:
    """The covariance of `beta` at a solution, by the sources of its errors.

    Args:
        problem: a recording's equations.
        solution: of these.
        off: deviations of `beta` that its equations do not know of.
    """
    state, prior, plain = solution.state, solution.prior, solution.weights
    factor = common_factor(problem, plain, state)
    R = prior.added(factor, state)[:-1, :-1]
    root = solve_triangular(R, np.eye(len(R)))
    C, apart = root @ root.T, off @ off.T
    beta = np.arange(OUTSIDE, OUTSIDE + state.beta.size)
    by_beta = C[:, beta]

    def part(rows: Float[np.ndarray, "rows common"]) -> Float[np.ndarray, "beta beta"]:
        """`C F C` of the information `F` in whitened equations."""
        shown = rows @ by_beta[: rows.shape[1]]
        return shown.T @ shown

    def known(which: Sequence[int]) -> Float[np.ndarray, "beta beta"]:
        """`C - C_k C_kk^-1 C_k'`, with unknowns `k` in their deviations."""
        std = np.sqrt(np.diag(C)[which])
        inverse = np.linalg.pinv(C[np.ix_(which, which)] / np.outer(std, std))
        shared = by_beta[which] / std[:, None]
        return C[np.ix_(beta, beta)] - shared.T @ inverse @ shared + apart

    seen = part(factor[:-1, :-1])
    parts = {}
    for name, weights in plain.items():
        raised = {**plain, name: np.sqrt(1 + RAISED) * weights}
        more = part(common_factor(problem, raised, state)[:-1, :-1])
        parts[name] = Source("noise", (more - seen) / RAISED)
    drifts = seen - np.sum([each.part for each in parts.values()], axis=0)
    parts["drifts"] = Source("recording", drifts)
    before = np.diag(1 / prior.std)
    for name, (kind, which) in _families(problem, solution).items():
        parts[name] = Source(kind, part(before[which]), known(which))
    parts["nominal values"] = Source("other", part(before[beta]))
    if len(prior.others):
        parts["other recordings"] = Source("recording", part(prior.others[:, :-1]))
    if off.any():
        parts["undecided"] = Source("other", apart)
    return parts


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
        families.setdefault(by_place[place], (kind, []))[1].append(k)
    return families
