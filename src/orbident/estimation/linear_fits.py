"""Linear identification: Eq. 24 for `pi` and Eq. 31 for `phi`.

Both are written in base axes, which turns their rows and changes nothing else:

    Y pi - R_0^T h_cm = -A_rw qd_rw + R_0^T h_given
    W phi + R_0^T v_cm = R_0^T v_S

Where `v_S` is an integrated accelerometer, its constant bias `b` is one more unknown:
`R_0^T (integral of R_0) b` is added on the left.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Literal, NamedTuple, get_args

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.estimation.triangular import Layout, LinearFit, fold, solve_factor
from orbident.model.minimal_sets import MinimalSets, Regressors
from orbident.model.rotations import quaternion_matrix
from orbident.model.wheel_arrays import Wheels, wheels_of
from orbident.preprocessing.samples import Batch, Samples
from orbident.robot.description import Robot

InitialMomentum = Literal["unknown", "at-rest", "first-sample"]
INITIAL_MOMENTA: tuple[InitialMomentum, ...] = get_args(InitialMomentum)

BATCH = 256
"""Samples folded in at once, at least: of a robot with two arms more are no faster,
and need 100 MB more at 1024."""

NUMBERS = 2**17
"""Numbers of the equations folded in at once: with fewer, most time goes to calls."""

STILL = 0.1
"""A base at rest turns less than this fraction of its later RMS rate."""


class Fits(NamedTuple):
    """Both linear estimates of one recording."""

    pi: LinearFit
    phi: LinearFit
    samples: int
    """Samples in which all that the momentum equation needs was measured."""
    h_rw: float
    """Norm of the wheels' momentum over these samples, N m s."""
    surprise: float
    """How much the first sample, with nominal inertia, contradicts a momentum that was
    taken as known; over the wheels' momentum, root mean square."""


class KnownMomentum(NamedTuple):
    """What Section 3.1 knows of the momentum: `h_cm - R_0 Y pi = h + Y_in pi`."""

    h: Float[np.ndarray, "3"]
    """Inertial axes, N m s."""
    Y_in: Float[np.ndarray, "h pi"]
    """`R_0 Y` of the first sample, where Eq. 24 subtracts it; else zero."""


def fit(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
    progress: Callable[[float], object],
    stretches: Iterable[Samples] | None = None,
) -> Fits:
    """Estimate `pi` and `phi` from all samples.

    Args:
        robot: geometry and wheels.
        sets: its minimal sets.
        samples: of a recording, or of a digest of it.
        initial_momentum: what is known of the momentum.
        progress: is called with the fraction of `samples` that is done.
        stretches: all samples, where `samples` are those of a digest.

    Raises:
        InputError: there are fewer equations than unknowns.
    """
    wheels, regressors = wheels_of(robot), sets.regressors
    axes_h, axes_v = len(regressors.momentum_axes), len(regressors.velocity_axes)
    pis, phis = sets.pi_of_beta.shape[0], sets.base.sigmas
    known = known_momentum(robot, sets, samples, initial_momentum)
    layout_h = momentum_layout(regressors, known, pis)
    # Beside v_cm, the bias of an accelerometer.
    layout_v = Layout(axes_v * (2 if samples.biased else 1), phis, 0)
    R_h = np.zeros((layout_h.columns,) * 2)
    R_v = np.zeros((layout_v.columns,) * 2)
    turning = moving = done = 0
    h_rw = 0.0
    size = max(BATCH, NUMBERS // (axes_h * layout_h.columns))
    every = (samples,) if stretches is None else stretches
    for batch, drift in chain.from_iterable(
        batches_with_drift(each, size) for each in every
    ):
        progress(min(done / samples.t.size, 1.0))
        done += batch.turning.size
        rows_h, rows_v = rows_of(regressors, wheels, known, batch, drift)
        R_h, R_v = fold(R_h, rows_h), fold(R_v, rows_v)
        turning += int(batch.turning.sum())
        moving += int(batch.moving.sum())
        h_rw = np.hypot(h_rw, np.linalg.norm(wheels.A_rw @ batch.qd_rw.T))
    _check_enough(samples.source, turning, axes_h, layout_h.nuisances + pis)
    return Fits(
        pi=solve_factor(R_h, layout_h, turning * axes_h),
        phi=solve_factor(R_v, layout_v, moving * axes_v),
        samples=turning,
        h_rw=float(h_rw),
        surprise=_surprise(robot, sets, samples, known, float(h_rw / np.sqrt(done))),
    )


def batches_with_drift(
    samples: Samples, size: int = BATCH
) -> Iterator[tuple[Batch, Float[np.ndarray, "n 3 3"] | None]]:
    """All samples in batches, and what an accelerometer's bias adds to each."""
    drift = samples.drift()
    for k, batch in enumerate(samples.batches(size)):
        own = slice(k * size, (k + 1) * size)
        yield batch, None if drift is None else drift[own]


def momentum_layout(
    regressors: Regressors, known: KnownMomentum | None, parameters: int
) -> Layout:
    """Unknown momentum is a nuisance; known, it is checked as if it were unknown."""
    axes = len(regressors.momentum_axes)
    if known is None:
        return Layout(axes, parameters, 0)
    return Layout(0, parameters, axes)


def rows_of(
    regressors: Regressors,
    wheels: Wheels,
    known: KnownMomentum | None,
    batch: Batch,
    drift: Float[np.ndarray, "n 3 3"] | None,
) -> tuple[Float[np.ndarray, "h h_columns"], Float[np.ndarray, "v v_columns"]]:
    """The rows of Eqs. 24 and 31 for a batch; zero where a sample is not valid.

    With `drift` those of Eq. 31 have the bias of an accelerometer among their unknowns.
    """
    turning, moving = regressors.momentum_axes, regressors.velocity_axes
    R_BW = np.swapaxes(quaternion_matrix(batch.x_WB), 1, 2)

    def in_base(x: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
        return np.einsum("nij,nj->ni", R_BW, x)

    R_turning = R_BW[:, turning][:, :, turning]
    Y, W = regressors(batch.q, batch.qd, batch.w)
    h = in_base(batch.h_given) - batch.qd_rw @ wheels.A_rw.T
    if known is None:
        momentum = [-R_turning, Y, h[:, turning, None]]
    else:
        h = h + R_BW @ known.h
        momentum = [Y - R_turning @ known.Y_in, -R_turning, h[:, turning, None]]
    v = in_base(batch.v_S)[:, moving, None]
    nuisances = [R_BW] if drift is None else [R_BW, R_BW @ drift]
    velocity = [*(by[:, moving][:, :, moving] for by in nuisances), W, v]
    return _stacked(momentum, batch.turning), _stacked(velocity, batch.moving)


def _stacked(
    parts: list[Float[np.ndarray, "n axes _"]], valid: Bool[np.ndarray, " n"]
) -> Float[np.ndarray, "rows columns"]:
    table = np.concatenate(parts, axis=2)
    table[~valid] = 0.0
    return table.reshape(-1, table.shape[2])


def known_momentum(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
) -> KnownMomentum | None:
    """Section 3.1's three cases; None where `h_cm` is unknown."""
    if initial_momentum == "unknown":
        return None
    first = samples.first()
    wheels, regressors = wheels_of(robot), sets.regressors
    nothing = np.zeros((len(regressors.momentum_axes), len(sets.pi_of_beta)))
    if first is None:
        return KnownMomentum(np.zeros(3), nothing)
    h_rw, Y_in = _seen_from_inertial_axes(regressors, wheels, first)
    if initial_momentum == "first-sample":
        return KnownMomentum(h_rw, Y_in)
    # Base at rest and wheels spinning: h_cm is theirs. Base already turning: all was
    # at rest before the wheels spun up, so h_cm = 0 (Eqs. 25 and 26).
    rms = np.sqrt(sum(np.nanmean(np.square(w)) for w in samples.w))
    still = np.linalg.norm(first.w[0]) <= STILL * rms
    return KnownMomentum(h_rw if still else np.zeros(3), nothing)


def _seen_from_inertial_axes(
    regressors: Regressors, wheels: Wheels, first: Batch
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "h pi"]]:
    """`R_0 A_rw qd_rw - h_given` and `R_0 Y` of a batch's only sample."""
    R_WB = quaternion_matrix(first.x_WB[0])
    Y, _ = regressors(first.q, first.qd, first.w)
    turning = regressors.momentum_axes
    h_rw = R_WB @ (wheels.A_rw @ first.qd_rw[0]) - first.h_given[0]
    return h_rw, R_WB[np.ix_(turning, turning)] @ Y[0]


def _surprise(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    known: KnownMomentum | None,
    size: float,
) -> float:
    """`|h_rw + R_0 Y pi_nominal - h_cm| / size` at the first sample.

    The size is the root mean square of the wheels' momentum in the whole recording: at
    the first sample wheels may stand still.
    """
    first = samples.first()
    if known is None or first is None or not size:
        return 0.0
    axes = np.array(sets.regressors.momentum_axes)
    h_rw, Y_in = _seen_from_inertial_axes(sets.regressors, wheels_of(robot), first)
    h_rs = (Y_in - known.Y_in) @ sets.pi(robot.theta)
    return float(np.linalg.norm(h_rw[axes] + h_rs - known.h[axes]) / size)


def _check_enough(source: str, samples: int, axes: int, unknowns: int) -> None:
    if samples * axes < unknowns:
        raise InputError(
            f"{source}: {samples} complete samples give {samples * axes} momentum "
            f"equations for {unknowns} unknowns; record at least "
            f"{-(-unknowns // axes)} samples with joints, wheels, gyro and attitude "
            "all measured"
        )
