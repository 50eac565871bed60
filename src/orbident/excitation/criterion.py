"""What is made small: one number from the information in a motion, with its gradient.

    cond   the condition number of `Y-hat` (Eq. 24)
    d      exp(-mean(l) / 2), the geometric mean of the standard deviations
    a      sqrt(mean(exp(-l))), their root mean square
    e      exp(-min l / 2), the largest

with `l` the logarithms of the eigenvalues of the information matrix. The search works
on the logarithm. Extreme eigenvalues are not smooth where they meet, and at an optimum
they do; generalised means of power `p` stand for them: never below, and the same for
`p = inf`.
"""

from typing import NamedTuple, get_args

import numpy as np
from jaxtyping import Float

from orbident.choices import Objective
from orbident.excitation.floating import Gradient, NodalMotion, block
from orbident.model.dependencies import independent_columns, random_motion
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.joint_schema import coupled_joints

OBJECTIVES: tuple[Objective, ...] = get_args(Objective)

SMALLEST = 1e-30
"""Below any eigenvalue that is more than rounding; keeps the logarithm finite."""


class Basis(NamedTuple):
    """Which parameters the columns of `Y` and `W` belong to."""

    pi_of: Float[np.ndarray, "pi basis_pi"]
    """The automatic `pi` is this times the one in use: its columns are `Y pi_of`."""
    phi_of: Float[np.ndarray, "phi basis_phi"]


def basis_of(robot: Robot, sets: MinimalSets) -> Basis:
    """The automatic parameters themselves, as many as coupled joints show."""
    Y, W = random_regressors(robot, sets)
    pi_of, phi_of = (
        np.eye(X.shape[-1])[:, independent_columns(X.reshape(-1, X.shape[-1])).columns]
        for X in (Y, W)
    )
    return Basis(pi_of, phi_of)


def random_regressors(
    robot: Robot, sets: MinimalSets
) -> tuple[Float[np.ndarray, "n h pi"], Float[np.ndarray, "n v phi"]]:
    """`Y` and `W` over random motion of the base and of the joints that follow none."""
    free, lead, offset = coupled_joints(robot)
    planar = robot.motion == "planar"
    q, qd, w = random_motion(4 * len(sets.pi_of_beta), len(free), planar)
    return sets.regressors(q @ lead.T + offset, qd @ lead.T, w)


class LogValue(NamedTuple):
    """The logarithm of a criterion, to be minimised."""

    smooth: float
    exact: float
    by_l: Float[np.ndarray, " n"]
    """The gradient of the smooth value with respect to `l`."""


def log_criterion(
    objective: Objective, l: Float[np.ndarray, " n"], p: float
) -> LogValue:
    """The logarithm of a criterion of the eigenvalues of an information matrix.

    The logarithms `l` of the eigenvalues ascend. The greater `p`, the closer are the
    means to extreme eigenvalues.
    """
    if objective == "d":
        value = float(-l.mean() / 2)
        return LogValue(value, value, np.full(l.size, -0.5 / l.size))
    if objective == "a":
        most, shares = smooth_maximum(-l, 1.0)
        value = (most - float(np.log(l.size))) / 2
        return LogValue(value, value, -shares / 2)
    low, by_low = smooth_maximum(-l, p)
    if objective == "e":
        return LogValue(low / 2, float(-l[0]) / 2, -by_low / 2)
    high, by_high = smooth_maximum(l, p)
    exact = float(l[-1] - l[0]) / 2
    return LogValue((high + low) / 2, exact, (by_high - by_low) / 2)


def smooth_maximum(
    x: Float[np.ndarray, "*n"], p: float
) -> tuple[float, Float[np.ndarray, "*n"]]:
    """`log (sum exp(x)^p)^(1/p)`, and its gradient: never below the greatest."""
    greatest = x.max()
    shares = np.exp(p * (x - greatest))
    whole = shares.sum()
    return float(greatest + np.log(whole) / p), shares / whole


def Y_hat(
    motion: NodalMotion,
    pi_of: Float[np.ndarray, "pi m"],
    axes: tuple[int, ...],
    at_rest: bool,
) -> Float[np.ndarray, "rows m"]:
    """`R_0 Y - (R_0 Y)_in`, inertial axes (Eq. 24).

    Angular momentum is conserved in `axes`. Where all was at rest before the wheels
    spun up, `Y_in = 0` (Eq. 26).
    """
    RY = block(motion.R, axes, axes) @ (motion.Y @ pi_of)
    RY = RY if at_rest else RY - RY[0]
    return RY.reshape(-1, RY.shape[-1])


def W_hat(
    motion: NodalMotion, phi_of: Float[np.ndarray, "phi m"], axes: tuple[int, ...]
) -> Float[np.ndarray, "rows m"]:
    """`[W, R_0^T]` with the velocity of the CM eliminated (Eq. 31), inertial axes."""
    # R_0 [W, R_0^T] = [R_0 W, 1]: a constant is what the mean takes away.
    RW = block(motion.R, axes, axes) @ (motion.W @ phi_of)
    RW = RW - RW.mean(axis=0)
    return RW.reshape(-1, RW.shape[-1])


class EigenSpectrum(NamedTuple):
    """Logarithms of eigenvalues, ascending, and their vectors."""

    l: Float[np.ndarray, " n"]
    vectors: Float[np.ndarray, "n n"]
    """The eigenvectors, in the rows."""


def spectrum_of_rows(rows: Float[np.ndarray, "m n"]) -> EigenSpectrum:
    """The spectrum of `rows^T rows`, by singular values: the product halves digits."""
    _, s, Vt = np.linalg.svd(np.linalg.qr(rows, mode="r"))
    return EigenSpectrum(2 * np.log(np.maximum(s[::-1], SMALLEST)), Vt[::-1])


def spectrum_of(F: Float[np.ndarray, "n n"]) -> EigenSpectrum:
    """The spectrum of a symmetric matrix."""
    s, V = np.linalg.eigh(F)
    return EigenSpectrum(np.log(np.maximum(s, SMALLEST)), V.T)


def by_matrix(
    spectrum: EigenSpectrum, by_l: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n n"]:
    """The gradient with respect to the matrix, from that with respect to `l`."""
    V = spectrum.vectors
    return (V.T * (by_l * np.exp(-spectrum.l))) @ V


def add_Y_hat(
    f: Gradient,
    by_rows: Float[np.ndarray, "rows m"],
    pi_of: Float[np.ndarray, "pi m"],
    axes: tuple[int, ...],
    at_rest: bool,
) -> None:
    """Adds the gradient, from that with respect to `Y-hat`."""
    by_RY = by_rows.reshape(len(f.motion.Y), len(axes), -1) @ pi_of.T
    if not at_rest:
        by_RY[0] -= by_RY.sum(axis=0)
    R = block(f.motion.R, axes, axes)
    f.Y += np.swapaxes(R, 1, 2) @ by_RY
    by_R = block(f.R, axes, axes)
    by_R += by_RY @ np.swapaxes(f.motion.Y, 1, 2)
