"""Linear identification: Eq. 24 for `pi` and Eq. 31 for `phi`.

Both are written in base axes, which turns their rows and changes nothing else:

    Y pi - R_0^T h_cm = -A_rw qd_rw + R_0^T h_given
    W phi + R_0^T v_cm = R_0^T v_S

Where `v_S` is an integrated accelerometer, its constant bias `b` is one more unknown:
`R_0^T (integral of R_0) b` is added on the left.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.choices import InitialMomentum
from orbident.errors import InputError
from orbident.estimation.triangular import Layout, LinearFit, fold, solve_factor
from orbident.model.core_robot import Wheels, wheels_of
from orbident.model.kinematics import inertia_at
from orbident.model.minimal_sets import MinimalSets, Regressors
from orbident.model.rotations import quaternion_matrix
from orbident.preprocessing.samples import Batch, Samples
from orbident.robot.description import Robot

BATCH = 256
"""Samples folded in at once, at least: of a robot with two arms more are no faster,
and need 100 MB more at 1024."""

NUMBERS = 2**17
"""Numbers of the equations folded in at once: with fewer, most time goes to calls."""

STILL = 0.1
"""A base at rest turns less than this fraction of its later RMS rate."""

HALF = 0.5
"""Part of the wheels' momentum that base and arms have the opposite of, by nominal
inertia: all of it if they turned as the wheels spun up, and none if they were held."""


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


class Factors(NamedTuple):
    """What samples say, as triangular factors: those of any samples can be joined."""

    R_h: Float[np.ndarray, "h_columns h_columns"]
    """Triangular factor of the momentum equation's rows (Eq. 24)."""
    R_v: Float[np.ndarray, "v_columns v_columns"]
    """Triangular factor of the velocity equation's rows (Eq. 31)."""
    rows: int
    turning: int
    """Samples in which all that the momentum equation needs was measured."""
    moving: int
    """Samples in which the velocity of S was measured too."""
    h_rw: float
    """Norm of the wheels' momentum, N m s."""

    def and_of(self, other: "Factors") -> "Factors":
        """What both say."""
        return Factors(
            fold(self.R_h, other.R_h),
            fold(self.R_v, other.R_v),
            self.rows + other.rows,
            self.turning + other.turning,
            self.moving + other.moving,
            float(np.hypot(self.h_rw, other.h_rw)),
        )


@dataclass(frozen=True)
class LinearEquations:
    """Eqs. 24 and 31 of one recording, for any of its samples."""

    regressors: Regressors
    wheels: Wheels
    known: KnownMomentum | None
    layout_h: Layout
    layout_v: Layout

    @classmethod
    def of(
        cls,
        robot: Robot,
        sets: MinimalSets,
        samples: Samples,
        initial_momentum: InitialMomentum,
    ) -> "LinearEquations":
        """Those of a recording of which these are all samples, or a digest."""
        regressors, pis = sets.regressors, sets.pi_of_beta.shape[0]
        known = known_momentum(robot, sets, samples, initial_momentum)
        # Beside v_cm, the bias of an accelerometer.
        nuisances = len(regressors.velocity_axes) * (2 if samples.biased else 1)
        return cls(
            regressors,
            wheels_of(robot),
            known,
            momentum_layout(regressors, known, pis),
            Layout(nuisances, sets.base.sigmas, 0),
        )

    def folded(
        self, samples: Samples, progress: Callable[[float], object] = lambda _: None
    ) -> Factors:
        """What some samples say."""
        axes = len(self.regressors.momentum_axes)
        R_h = np.zeros((self.layout_h.columns,) * 2)
        R_v = np.zeros((self.layout_v.columns,) * 2)
        rows = turning = moving = 0
        h_rw = 0.0
        size = max(BATCH, NUMBERS // (axes * self.layout_h.columns))
        for batch, drift in batches_with_drift(samples, size):
            progress(min(rows / samples.t.size, 1.0))
            rows += batch.turning.size
            rows_h, rows_v = rows_of(
                self.regressors, self.wheels, self.known, batch, drift
            )
            R_h, R_v = fold(R_h, rows_h), fold(R_v, rows_v)
            turning += int(batch.turning.sum())
            moving += int(batch.moving.sum())
            h_rw = np.hypot(h_rw, np.linalg.norm(self.wheels.A_rw @ batch.qd_rw.T))
        return Factors(R_h, R_v, rows, turning, moving, float(h_rw))

    def solved(
        self, robot: Robot, sets: MinimalSets, samples: Samples, factors: Factors
    ) -> Fits:
        """Both estimates.

        Args:
            robot: geometry and wheels.
            sets: its minimal sets.
            samples: of the recording, or of a digest of it.
            factors: of all samples.

        Raises:
            InputError: there are fewer equations than unknowns.
        """
        axes_h, axes_v = (
            len(axes)
            for axes in (self.regressors.momentum_axes, self.regressors.velocity_axes)
        )
        turning, layout = factors.turning, self.layout_h
        unknowns = layout.nuisances + layout.parameters
        _check_enough(samples.source, turning, axes_h, unknowns)
        size = factors.h_rw / np.sqrt(factors.rows)
        return Fits(
            pi=solve_factor(factors.R_h, layout, turning * axes_h),
            phi=solve_factor(factors.R_v, self.layout_v, factors.moving * axes_v),
            samples=turning,
            h_rw=factors.h_rw,
            surprise=_surprise(robot, sets, samples, self.known, size),
        )


def fit(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
    progress: Callable[[float], object],
) -> Fits:
    """Estimate `pi` and `phi` from all samples.

    Args:
        robot: geometry and wheels.
        sets: its minimal sets.
        samples: of a recording.
        initial_momentum: what is known of the momentum.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: there are fewer equations than unknowns.
    """
    equations = LinearEquations.of(robot, sets, samples, initial_momentum)
    return equations.solved(robot, sets, samples, equations.folded(samples, progress))


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
    own, theirs = Y_in @ sets.pi(robot.theta), h_rw[[*regressors.momentum_axes]]
    # Arms may turn a light base far later on; wheels may be recorded in another unit.
    still = np.linalg.norm(first.w[0]) <= STILL * rms
    still &= bool(-own @ theirs < HALF * (theirs @ theirs))
    return KnownMomentum(h_rw if still else np.zeros(3), nothing)


def rest_std(robot: Robot, h_rw: float) -> Float[np.ndarray, "3"]:
    """Standard deviations of the momentum of a robot that is said to be at rest, N m s.

    Args:
        robot: which says how still that is.
        h_rw: the wheels' momentum, N m s.
    """
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    # Of CAD values that no body can have, D may be anything.
    return np.hypot(
        robot.at_rest.spin * np.abs(np.diag(D)), robot.at_rest.wheels * h_rw
    )


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
