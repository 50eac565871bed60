"""What sensors show of what is true: when, how late, how surely and how well.

Noise processes are those of IEEE Std 952, Annex C, of all axes at once. A *rate* sample
(angular rate, specific force) is a mean over the interval `dt` that ends with it.
Spectral densities are two-sided. The Allan deviation at averaging time `tau` of white
noise is `N / sqrt(tau)`, and that of flicker noise is flat,
`sqrt(2 ln 2 / pi) B = 0.664 B`: that is the floor from which a data sheet's bias
instability `B` is read.

Random numbers: one seed, and a stream of its own for whatever has a name.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_banded
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix, quaternion_rate, rotate_back
from orbident.robot.sensor_schema import (
    AccelerometerSpec,
    AttitudeSpec,
    InertialSpec,
    PositionSpec,
    Sampled,
    TrackerSpec,
)

Random = np.random.Generator
Vectors = Float[np.ndarray, "n 3"]
Samples = Float[np.ndarray, "n axes"]
"""By axis."""


def stream(seed: int, name: str) -> Random:
    """The random numbers of one sensor.

    A child of `SeedSequence(seed)` whose spawn key is the name, so that a sensor that
    is added, removed or changed leaves every other one's numbers as they were. The seed
    is that of the whole recording, zero or more.

    Raises:
        InputError: the seed is not a whole number of zero or more.
    """
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"seed {seed!r}: give a whole number of zero or more")
    children = np.random.SeedSequence(int(seed), spawn_key=tuple(name.encode()))
    return np.random.default_rng(children)


def markov(
    random: Random,
    t: Float[np.ndarray, " n"],
    std: Float[np.ndarray, " axes"],
    correlation_time: Float[np.ndarray, " axes"],
    from_zero: bool = False,
) -> Samples:
    """A first-order Gauss-Markov process, at any increasing times (IEEE 952, C.1.5).

    `x_0 ~ N(0, s^2)`, `x_k = a_k x_{k-1} + s sqrt(1 - a_k^2) n_k` with
    `a_k = exp(-(t_k - t_{k-1}) / T)`: exact, however far apart the samples are. Each
    axis has its own `s`, in the unit of the result, and `T`, in seconds as `t` is,
    which is infinite for what stays. The process is stationary, or `x_0 = 0`. Its Allan
    deviation peaks at `0.617 s`, at the averaging time 1.89 T, and rises as `sqrt(tau)`
    for shorter times.
    """
    steps = np.diff(t)[:, None] / correlation_time
    kicks = random.normal(scale=std, size=(t.size, std.size))
    kicks[:1] *= not from_zero
    # expm1: T may be long, and infinite.
    kicks[1:] *= np.sqrt(-np.expm1(-2 * steps))
    # The recursion as equations with one diagonal below the main one.
    bands = np.ones((2, t.size))
    for axis, step in enumerate(steps.T):
        bands[1, :-1] = -np.exp(-step)
        kicks[:, axis] = solve_banded((1, 0), bands, kicks[:, axis])
    return kicks


def random_walk(
    random: Random, t: Float[np.ndarray, " n"], density: Float[np.ndarray, " axes"]
) -> Samples:
    """A random walk, `var(x(t)) = q^2 (t - t_0)`, at any increasing times.

    Times are in s, and q, by axis, is in its unit per square root of a second.
    """
    steps = np.sqrt(np.diff(t, prepend=t[:1]))[:, None] * density
    return np.cumsum(random.normal(scale=steps), axis=0)


_ROUNDING = 1e-6
"""Relative: times in files have so many digits."""

Reading = Callable[[Float[np.ndarray, "n true"], float, Random], Samples]
"""What a sensor shows of true values `dt` apart."""


def sensor_columns(
    sensor: Sampled,
    t: Float[np.ndarray, " rows"],
    true: Float[np.ndarray, "rows true"],
    random: Random,
    read: Reading,
) -> Float[np.ndarray, "rows axes"]:
    """The columns of a recording of a sensor that samples evenly, on every k-th row.

    Rows are at the times `t`, evenly spaced, s; the true values are without noise.
    Samples are NaN on rows without one.

    Raises:
        InputError: the rows are not evenly spaced, or the rate is not theirs divided
            by a whole number.
    """
    noise, losses = random.spawn(2)
    stride, dt = _stride(sensor.rate, t)
    rows = slice(None, None, stride)
    if late := sensor.latency:
        if t.size < 4:
            raise InputError(f"latency: needs at least 4 rows, found {t.size}")
        # The values of so long ago; NaN where that is before the first row.
        at_rows = CubicSpline(t, true, extrapolate=False)(t[rows] - late)
    else:
        at_rows = true[rows]
    shown = read(at_rows, dt, noise)
    lost = losses.random((len(shown), 1)) < (sensor.drop_out or 0.0)
    columns = np.full((t.size, shown.shape[1]), np.nan)
    columns[rows] = np.where(lost, np.nan, shown)
    return columns


def _stride(rate: float | None, t: Float[np.ndarray, " rows"]) -> tuple[int, float]:
    """Rows from one sample to the next, and the time between these, s."""
    row = float(t[-1] - t[0]) / (t.size - 1)
    if np.abs(np.diff(t) - row).max() > _ROUNDING * row:
        raise InputError(
            f"rows are {np.diff(t).min():g} to {np.diff(t).max():g} s apart; "
            "sensors sample evenly, so simulate at a constant rate"
        )
    if rate is None:
        return 1, row
    stride = round(1 / (rate * row))
    if abs(stride * rate * row - 1) > _ROUNDING:
        raise InputError(
            f"rate: found {rate:g} Hz, but the recording has {1 / row:g} rows "
            "a second; give that divided by a whole number, or simulate at a "
            "multiple of the sensor's rate"
        )
    return stride, stride * row


NONE = (0.0, 0.0, 0.0)
"""Errors that are not declared."""


def read_inertial(
    sensor: InertialSpec, true: Vectors, dt: float, random: Random
) -> Vectors:
    """What three orthogonal axes show, nominally the base's, as means over `dt`.

    `shown = (1 + scale) (R_BS^T true) + constant_bias + turn_on + drift(t) + white`, by
    axis, `R_BS = exp [misalignment]x`, `turn_on ~ N(0, turn_on_bias^2)`, which is the
    bias instability where it is not declared. The true values are means over the `dt`
    seconds before each sample, rad/s or m/s^2.
    """
    white, turn_on, drift = random.spawn(3)
    start = sensor.turn_on_bias
    start = sensor.bias_instability if start is None else start
    bias = turn_on.normal(scale=start, size=(1, 3)) + (sensor.constant_bias or NONE)
    std, lasts = np.full((2, 3), [[sensor.drift_std], [sensor.drift_time]])
    R_BS = Rotation.from_rotvec(sensor.misalignment or NONE).as_matrix()
    return (
        (1 + np.array(sensor.scale or NONE)) * (true @ R_BS)
        + bias
        + markov(drift, dt * np.arange(len(true)), std, lasts, from_zero=True)
        + white.normal(scale=sensor.white_std(dt), size=true.shape)
    )


def read_increments(
    sensor: AccelerometerSpec, true: Float[np.ndarray, "n 7"], dt: float, random: Random
) -> Vectors:
    """What S's velocity changed by since the sample before, in the base axes of then.

    `R_0(t_{k-1}) dv_k = v_S(t_k) - v_S(t_{k-1})`, exactly but for errors and noise: the
    increments of a unit that corrects for its own turning in between (sculling), m/s.
    It is NaN for the first sample, which has none before it. The true values, `dt`
    seconds apart, are attitude (quaternion) and velocity of S, inertial axes, m/s.
    """
    R_WB, dv = quaternion_matrix(true[:-1, :4]), np.diff(true[:, 4:], axis=0)
    change = np.concatenate([np.full((1, 3), np.nan), rotate_back(R_WB, dv)])
    return dt * read_inertial(sensor, change / dt, dt, random)


def read_scalars(
    std: float, resolution: float, true: Samples, dt: float, random: Random
) -> Samples:
    """What encoders, tachometers and torque sensors show, in the unit of `true`.

    `shown = resolution round((true + n) / resolution)`, with white `n`. Encoders of
    wheels count over full turns; tachometers and torque sensors have no resolution.
    The paper has none of these two (Section 3.5).
    """
    del dt
    shown = true + random.normal(scale=std, size=true.shape)
    return resolution * np.round(shown / resolution) if resolution else shown


def read_attitude(
    sensor: AttitudeSpec, true: Float[np.ndarray, "n 4"], dt: float, random: Random
) -> Float[np.ndarray, "n 4"]:
    """Unit quaternions, scalar last, of attitudes `dt` seconds apart.

    `shown = true (x) exp(d / 2)`, with `d` the noise about each base axis.
    """
    x_WB = true / np.linalg.norm(true, axis=1, keepdims=True)
    d = _noise(sensor, len(true), dt, random)
    half = np.linalg.norm(d, axis=1, keepdims=True) / 2
    # The product with (v, s) is s x + d/dt x at the rate 2 v; v = sin(half) d/|d|.
    v = np.sinc(half / np.pi) * d / 2
    return np.cos(half) * x_WB + quaternion_rate(x_WB, 2 * v)


def read_position(
    sensor: PositionSpec, true: Vectors, dt: float, random: Random
) -> Vectors:
    """Positions of S, inertial axes, m, `dt` seconds apart."""
    return true + _noise(sensor, len(true), dt, random)


def _noise(sensor: TrackerSpec, n: int, dt: float, random: Random) -> Vectors:
    """The errors of samples `dt` apart, white and coloured."""
    white, of = random.normal(scale=sensor.white_std(dt), size=(n, 3)), sensor.coloured
    if of.absent:
        return white
    t, (lasting, walking) = dt * np.arange(n), random.spawn(2)
    slow = markov(lasting, t, of.markov_std, of.correlation_time)
    return white + slow + random_walk(walking, t, of.random_walk)
