"""What sensors show of what is true: when, how late, how surely and how well."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix, quaternion_rate, rotate_back
from orbident.robot.sensor_schema import (
    AccelerometerSpec,
    AttitudeSpec,
    EncoderSpec,
    InertialSpec,
    PositionSpec,
    Sampled,
    TrackerSpec,
)
from orbident.simulation.noise_processes import (
    bias_drift,
    coloured,
    gaussian,
    quantised,
)

_ROUNDING = 1e-6

Reading = Callable[
    [Float[np.ndarray, "n true"], float, np.random.Generator],
    Float[np.ndarray, "n axes"],
]
"""What a sensor shows of true values `dt` apart."""


def sensor_columns(
    sensor: Sampled,
    t: Float[np.ndarray, " rows"],
    true: Float[np.ndarray, "rows true"],
    random: np.random.Generator,
    read: Reading,
) -> Float[np.ndarray, "rows axes"]:
    """The columns of a recording of a sensor that samples evenly, on every k-th row.

    Args:
        sensor: its rate, latency and drop-outs.
        t: times of the rows, evenly spaced, s.
        true: the noise-free values at the rows.
        random: the sensor's stream.
        read: what it shows at a row.

    Returns:
        The samples; NaN on rows without one.

    Raises:
        InputError: the rows are not evenly spaced, or the rate is not theirs divided
            by a whole number.
    """
    noise, losses = random.spawn(2)
    stride, dt = _stride(sensor.rate, t)
    rows = slice(None, None, stride)
    late = sensor.latency
    true = _delayed(t, true, t[rows], late) if late else true[rows]
    shown = read(true, dt, noise)
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


def _delayed(
    t: Float[np.ndarray, " rows"],
    true: Float[np.ndarray, "rows axes"],
    at: Float[np.ndarray, " n"],
    latency: float,
) -> Float[np.ndarray, "n axes"]:
    """The values of so long ago; NaN where that is before the first row."""
    if t.size < 4:
        raise InputError(f"latency: needs at least 4 rows, found {t.size}")
    return CubicSpline(t, true, extrapolate=False)(at - latency)


NONE = (0.0, 0.0, 0.0)
"""Errors that are not declared."""


def read_inertial(
    sensor: InertialSpec,
    true: Float[np.ndarray, "n 3"],
    dt: float,
    random: np.random.Generator,
) -> Float[np.ndarray, "n 3"]:
    """What three orthogonal axes show, nominally the base's, as means over `dt`.

    `shown = (1 + scale) (R_BS^T true) + constant_bias + turn_on + drift(t) + white`,
    by axis, `R_BS = exp [misalignment]x`, `turn_on ~ N(0, turn_on_bias^2)`, which is
    the bias instability where it is not declared.

    Args:
        sensor: what is declared of it.
        true: means over the `dt` seconds before each sample, rad/s or m/s^2.
        dt: from one sample to the next, s.
        random: the sensor's stream.
    """
    white, turn_on, drift = random.spawn(3)
    start = sensor.turn_on_bias
    start = sensor.bias_instability if start is None else start
    bias = gaussian(turn_on, (1, 3), start) + np.array(sensor.constant_bias or NONE)
    R_BS = Rotation.from_rotvec(sensor.misalignment or NONE).as_matrix()
    return (
        (1 + np.array(sensor.scale or NONE)) * (true @ R_BS)
        + bias
        + bias_drift(drift, true.shape, sensor.drift_std, sensor.drift_time, dt)
        + gaussian(white, true.shape, sensor.white_std(dt))
    )


def read_increments(
    sensor: AccelerometerSpec,
    true: Float[np.ndarray, "n 7"],
    dt: float,
    random: np.random.Generator,
) -> Float[np.ndarray, "n 3"]:
    """Velocity increments since the sample before, m/s; NaN for the first.

    Args:
        sensor: what is declared of it.
        true: attitude (quaternion) and velocity of S (inertial axes, m/s).
        dt: from one sample to the next, s.
        random: the sensor's stream.
    """
    mean_force = velocity_increments(true[:, :4], true[:, 4:]) / dt
    return dt * read_inertial(sensor, mean_force, dt, random)


def velocity_increments(
    x_WB: Float[np.ndarray, "n 4"], v_S: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    """What S's velocity changed by since the sample before, in the base axes of then.

    `R_0(t_{k-1}) dv_k = v_S(t_k) - v_S(t_{k-1})`, exactly: the increments of a unit
    that corrects for its own turning in between (sculling).

    Args:
        x_WB: attitude of the base.
        v_S: velocity of S, inertial axes, m/s.

    Returns:
        m/s; NaN for the first sample, which has none before it.
    """
    change = rotate_back(quaternion_matrix(x_WB[:-1]), np.diff(v_S, axis=0))
    return np.concatenate([np.full((1, 3), np.nan), change])


def read_angles(
    sensor: EncoderSpec,
    true: Float[np.ndarray, "n axes"],
    dt: float,
    random: np.random.Generator,
) -> Float[np.ndarray, "n axes"]:
    """What encoders show, rad or m; those of wheels count over full turns.

    `shown = resolution round((true + n) / resolution)`, with white `n`.
    """
    del dt
    noisy = true + gaussian(random, true.shape, sensor.white_noise or 0.0)
    return quantised(noisy, sensor.resolution or 0.0)


def read_rates(
    sensor: EncoderSpec,
    true: Float[np.ndarray, "n axes"],
    dt: float,
    random: np.random.Generator,
) -> Float[np.ndarray, "n axes"]:
    """What tachometers show, rad/s or m/s. The paper has none (Section 3.5)."""
    del dt
    return true + gaussian(random, true.shape, sensor.tachometer or 0.0)


def read_attitude(
    sensor: AttitudeSpec,
    true: Float[np.ndarray, "n 4"],
    dt: float,
    random: np.random.Generator,
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
    sensor: PositionSpec,
    true: Float[np.ndarray, "n 3"],
    dt: float,
    random: np.random.Generator,
) -> Float[np.ndarray, "n 3"]:
    """Positions of S, inertial axes, m, `dt` seconds apart."""
    return true + _noise(sensor, len(true), dt, random)


def _noise(
    sensor: TrackerSpec, n: int, dt: float, random: np.random.Generator
) -> Float[np.ndarray, "n 3"]:
    """The errors of samples `dt` apart, white and coloured."""
    white = gaussian(random, (n, 3), sensor.white_std(dt))
    if sensor.coloured.absent:
        return white
    return white + coloured(random, dt * np.arange(n), sensor.coloured)
