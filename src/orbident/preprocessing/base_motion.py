"""Attitude and rate of the base, and the velocity of S, at the rows of a recording.

The rate may come from the attitude alone, and the velocity from positions or from what
an accelerometer at S felt. An attitude that nobody recorded may follow from a velocity.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.gaussian import white_std_of
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import UNTURNED
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.integrals import (
    GyroNoise,
    fuse_attitude,
    integrate_gyro,
    velocity_from_accelerometer,
    velocity_from_increments,
)
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rates import at_times
from orbident.preprocessing.smoothing import Settings, fits_of, smooth_rates
from orbident.recordings.columns import vector_columns
from orbident.recordings.long_recording import LARGE
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import SensorsSpec

REMEMBERED = 4
"""Motions of the base: while a cause is looked for, most stay as they were."""


def attitude_rates(
    t: Float[np.ndarray, " n"],
    fixes: Float[np.ndarray, "n 4"],
    name: str = "attitude",
    settings: Settings | None = None,
) -> tuple[Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"]]:
    """Attitude and rate, each component of the quaternion smoothed for itself.

    `w = 2 vec(conj(x) (x) dx/dt)`, the inverse of `dx/dt = 1/2 x (x) (w, 0)`.

    Args:
        t: times, s.
        fixes: unit quaternions of either sign, scalar last; NaN where there is none.
        name: what this is, for messages.
        settings: of the whole recording, where these are a stretch of it.

    Returns:
        The smoothed attitude, and the rate in base axes, rad/s; NaN on rows without a
        fix.

    Raises:
        InputError: there are fewer than four fixes.
    """
    label, signed = f"{name}: attitude", same_sign(fixes)
    settings = settings or Settings()
    fits = settings.smoothers("attitude", lambda: fits_of(t, signed, name=label))
    smoothed = smooth_rates(t, signed, t, label, fits)
    size = np.linalg.norm(smoothed.x, axis=1, keepdims=True)
    # Of the unit quaternion x / |x|; what changes |x| drops out of the vector part.
    x, x_dot = smoothed.x / size, smoothed.rate / size
    v, s, v_dot, s_dot = x[:, :3], x[:, 3:], x_dot[:, :3], x_dot[:, 3:]
    w = 2 * (s * v_dot - s_dot * v - np.cross(v, v_dot))
    missing = np.isnan(fixes).any(axis=1)
    x[missing], w[missing] = np.nan, np.nan
    return x, w


def same_sign(x: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
    """The same attitudes, each on the side of the one before: `x` and `-x` are equal.

    Args:
        x: unit quaternions; NaN where there is none.
    """
    valid = ~np.isnan(x).any(axis=1)
    product = np.sum(x[valid][1:] * x[valid][:-1], axis=1)
    signs = np.cumprod(np.concatenate([[1.0], np.where(product < 0, -1.0, 1.0)]))
    turned = x.copy()
    turned[valid] *= signs[: valid.sum(), None]
    return turned


LEAST_N = 1e-9
"""rad/sqrt(s)."""

LEAST_STD = 1e-9
"""rad: without noise the weights would be infinite."""


class BaseMotion(NamedTuple):
    """Columns; a row counts where the base rate is no NaN."""

    w: Columns
    """Base axes, rad/s."""
    x_WB: Columns
    origins: dict[str, Origin]


def base_motion(
    recording: Recording, sensors: SensorsSpec, late: float, settings: Settings
) -> BaseMotion:
    """What gyro and attitude say together, or one of them alone.

    Where most rows have both, they are used as they are. Without an attitude the
    inertial axes are those of the base at the gyro's first sample.

    Args:
        recording: with a gyro, an attitude, or both.
        sensors: as the robot file has them, for the noise of both.
        late: by how much the attitude's times are behind the gyro's, s.
        settings: of the whole recording.

    Raises:
        InputError: there is neither, or too few samples.
    """
    gyro, attitude = vector_columns("gyro"), vector_columns("attitude")
    needed = recording.columns.keys().isdisjoint(attitude)
    w = _recorded(recording, gyro, needed)
    fixes = _recorded(recording, attitude)
    t, source = recording.t, recording.source
    if not fixes:
        x = integrate_gyro(t, np.column_stack(w), UNTURNED, source)
        how = {"attitude": Origin.INTEGRATED_GYRO, "base_rate": Origin.MEASURED}
        return BaseMotion(w, tuple(x.T), how)
    if not w:
        x, rate = attitude_rates(t, np.column_stack(fixes), source, settings)
        how = _both(Origin.SMOOTHED_ATTITUDE)
        return BaseMotion(tuple(rate.T), tuple(x.T), how)
    if not late and not settings.once("sparse", lambda: _sparse(w, fixes)):
        return BaseMotion(w, fixes, _both(Origin.MEASURED))
    gyro, attitude = sensors.of("gyro"), sensors.of("attitude").white_std()
    samples = [t.tobytes(), *(np.column_stack(x).tobytes() for x in (w, fixes))]
    # Of many samples what is remembered would take much memory.
    fused = _fused if t.size < LARGE else _fused.__wrapped__
    return fused(*samples, gyro.white_std(), gyro.bias_walk, attitude, late, source)


def _both(how: Origin) -> dict[str, Origin]:
    return {"attitude": how, "base_rate": how}


def _recorded(
    recording: Recording, names: tuple[str, ...], needed: bool = False
) -> Columns:
    """A sensor's columns; none where it is not there, as it has none of them."""
    if not needed and recording.columns.keys().isdisjoint(names):
        return ()
    return tuple(recording.column(name) for name in names)


def _sparse(w: Columns, fixes: Columns) -> bool:
    """Whether most rows that have a gyro sample lack an attitude."""
    seen, fixed = (
        np.logical_and.reduce([~np.isnan(column) for column in columns])
        for columns in (w, fixes)
    )
    return bool((seen & fixed).sum() < seen.sum() / 2)


@lru_cache(REMEMBERED)
def _fused(
    times: bytes,
    rates: bytes,
    attitudes: bytes,
    white: float,
    walk: float,
    std: float,
    late: float,
    source: str,
) -> BaseMotion:
    """What gyro and attitude say together.

    Args:
        times: of rows, s.
        rates: of the base by the gyro, base axes, rad/s.
        attitudes: quaternions, scalar last.
        white: angle random walk of the gyro, rad/sqrt(s); zero if not declared.
        walk: of its bias, rad/s/sqrt(s).
        std: of an attitude, rad; zero if not declared.
        late: by how much attitudes are behind, s.
        source: of the recording.
    """
    t, w = np.frombuffer(times), np.frombuffer(rates).reshape(-1, 3)
    fixes = np.frombuffer(attitudes).reshape(-1, 4)
    by_gyro = integrate_gyro(t, w, UNTURNED, source)
    if late:
        fixes = _caught_up(t, fixes, by_gyro, late)
    std = std or _scatter(by_gyro, fixes)
    noise = GyroNoise(max(white or _white_noise(t, w), LEAST_N), walk)
    fused = fuse_attitude(t, w, fixes, noise, std, source)
    how = _both(Origin.FUSED_ATTITUDE)
    return BaseMotion(tuple((w - fused.bias).T), tuple(fused.x_WB.T), how)


def _caught_up(
    t: Float[np.ndarray, " n"],
    fixes: Float[np.ndarray, "n 4"],
    by_gyro: Float[np.ndarray, "n 4"],
    late: float,
) -> Float[np.ndarray, "n 4"]:
    """What late fixes would be now: turned on by what the gyro felt since then."""
    known = np.isfinite(by_gyro).all(axis=1)
    then = CubicSpline(t[known], by_gyro[known], extrapolate=False)(t - late)
    usable = np.isfinite(np.hstack([fixes, by_gyro, then])).all(axis=1)
    now = Rotation.from_quat(by_gyro[usable])
    felt = Rotation.from_quat(then[usable]).inv() * now
    moved = np.full(fixes.shape, np.nan)
    moved[usable] = (Rotation.from_quat(fixes[usable]) * felt).as_quat()
    return moved


def _white_noise(t: Float[np.ndarray, " n"], w: Float[np.ndarray, "n 3"]) -> float:
    """That of a gyro as its samples' second differences show it, rad/sqrt(s)."""
    seen = np.isfinite(w).all(axis=1)
    dt = np.median(np.diff(t[seen]))
    return float(white_std_of(np.diff(w[seen], n=2, axis=0), 2) * np.sqrt(dt))


def _scatter(
    by_gyro: Float[np.ndarray, "n 4"], fixes: Float[np.ndarray, "n 4"]
) -> float:
    """Std of fixes, rad: turns between neighbours, less what the gyro felt."""
    both = np.isfinite(np.hstack([by_gyro, fixes])).all(axis=1)
    error = Rotation.from_quat(fixes[both]) * Rotation.from_quat(by_gyro[both]).inv()
    between = (error[1:] * error[:-1].inv()).as_rotvec()
    if both.sum() < 2:
        return LEAST_STD
    return max(float(white_std_of(between, 1)), LEAST_STD)


class PointVelocity(NamedTuple):
    """Columns; empty where they cannot be had."""

    v_S: Columns
    """Inertial axes, m/s; but for a constant where it is derived from forces."""
    origin: Origin


def point_velocity(
    recording: Recording, x_WB: Columns, delays: Mapping[str, float], settings: Settings
) -> PointVelocity:
    """Velocities as measured; or from positions, or from an accelerometer.

    Args:
        recording: of any sensors.
        x_WB: attitude of the base at every row.
        delays: by sensor, s.
        settings: of the whole recording.

    Raises:
        InputError: a column has too few samples.
    """
    if recording.has_vector("velocity"):
        columns = tuple(recording.columns[name] for name in vector_columns("velocity"))
        if late := delays["position"]:
            t, label = recording.t, f"{recording.source}: velocity"
            columns = tuple(at_times(t, each, t + late, label) for each in columns)
        return PointVelocity(columns, Origin.MEASURED)
    if recording.has_vector("position"):
        at = recording.t + delays["position"]
        label = f"{recording.source}: position"
        t, r_S = recording.t, recording.vector("position")
        fits = settings.smoothers("position", lambda: fits_of(t, r_S, name=label))
        rate = smooth_rates(t, r_S, at, label, fits).rate
        return PointVelocity(tuple(rate.T), Origin.SMOOTHED_POSITIONS)
    for sensor, how in (
        ("accelerometer", Origin.INTEGRATED_ACCELEROMETER),
        ("velocity_increment", Origin.SUMMED_INCREMENTS),
    ):
        if recording.has_vector(sensor):
            return _felt(recording, np.column_stack(x_WB), sensor, how)
    return PointVelocity((), Origin.MISSING)


def _felt(
    recording: Recording, x_WB: Float[np.ndarray, "n 4"], sensor: str, how: Origin
) -> PointVelocity:
    known = np.isfinite(x_WB).all(axis=1)
    t, x, felt = recording.t[known], x_WB[known], recording.vector(sensor)[known]
    if sensor == "accelerometer":
        v = velocity_from_accelerometer(t, x, felt, recording.source)
    else:
        v = velocity_from_increments(x, felt)
    columns = np.full((3, known.size), np.nan)
    columns[:, known] = v.T
    return PointVelocity(tuple(columns), how)


ROWS = 500
"""So many rows, evenly spaced, show three angles as well as all do."""

ROUNDS = 100
"""Rounds that are made at most: a dozen are usual."""

SETTLED = 1e-6
"""rad: an attitude that changes by less from round to round has settled."""

NO_TURN = 1e-3
"""Over all velocities: what an attitude of zero weighs, where they show none."""


def with_first_attitude(
    robot: Robot, q: Columns, qd: Columns, w: Columns, x_WB: Columns, v_S: Columns
) -> Columns:
    """The attitude at all rows, in the axes of the velocity, that nobody recorded.

    A gyro shows how a base turned since its first sample, `R(t)`. With `R_0` its
    attitude then, Eq. 31 is, up to the constant velocity of the CM,

        v_S(t) = R_0 R(t) W phi

    which is linear in `phi`, and of `R_0` is Wahba's problem (Kabsch 1976). Each is
    solved with the other known, in turn, from nominal `phi` on. In the plane turns
    commute, and another `R_0` is another `phi`: there inertial axes are those of the
    base at first.

    Args:
        robot: with its nominal inertia.
        q: rad or m.
        qd: rad/s or m/s.
        w: base axes, rad/s.
        x_WB: from an attitude of zero on.
        v_S: inertial axes, m/s.
    """
    every = np.column_stack([*q, *qd, *w, *x_WB, *v_S])
    rows = np.flatnonzero(np.isfinite(every).all(axis=1))
    if not rows.size:
        return x_WB
    rows = rows[:: max(rows.size // ROWS, 1)]
    ends = np.cumsum([len(q), len(qd), len(w), len(x_WB)])
    q_, qd_, w_, x_, v = np.split(every[rows], ends, axis=1)
    sets = minimal_sets(robot)
    _, W = sets.regressors(*map(np.ascontiguousarray, (q_, qd_, w_)))
    W = Rotation.from_quat(x_).as_matrix() @ W
    W, v = W - W.mean(axis=0), v - v.mean(axis=0)
    size = np.linalg.norm(v)
    if not 0 < size < np.inf:
        return x_WB
    phi, first = sets.phi(robot.theta), Rotation.identity()
    none = NO_TURN * size * np.eye(3)
    for _ in range(ROUNDS):
        before = first
        shown, predicted = np.vstack([v, none]), np.vstack([W @ phi, none])
        first = Rotation.align_vectors(shown, predicted)[0]
        left = first.inv().apply(v) - W @ phi
        phi = phi + np.linalg.lstsq(W.reshape(-1, phi.size), left.ravel())[0]
        if (first * before.inv()).magnitude() < SETTLED:
            break
    known = np.isfinite(np.column_stack(x_WB)).all(axis=1)
    x = np.column_stack(x_WB)
    x[known] = (first * Rotation.from_quat(x[known])).as_quat()
    return tuple(x.T)
