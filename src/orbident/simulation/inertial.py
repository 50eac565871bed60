"""Gyros and accelerometers: a turned and scaled truth, a bias, white noise."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix, rotate_back
from orbident.robot.sensor_suites import CORRELATION_TIME
from orbident.simulation.noise_processes import bias_drift, gaussian, random_walk_rate
from orbident.simulation.sensor import Sensor, require

Vector = tuple[float, float, float]
NONE: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class InertialSensor(Sensor):
    """Three orthogonal axes, nominally the base's.

    `shown = (1 + scale) (R_BS^T true) + constant_bias + turn_on + drift(t) + white`,
    by axis, `R_BS = exp [misalignment]x`, `turn_on ~ N(0, turn_on_bias^2)`. What
    `turn_on`, `drift` and `white` are drawn from is in
    `orbident.simulation.noise_processes`.

    Raises:
        InputError: a value is negative, not a number, or not three numbers.
    """

    bias_instability: float = 0.0
    """`B`, rad/s or m/s^2: the floor of the Allan deviation over 0.664."""
    correlation_time: float = CORRELATION_TIME
    """Correlation time of the bias's drift, s; infinite for a bias that stays."""
    turn_on_bias: float | None = None
    """Std of the bias at the first sample, in B's unit; B where it is not given."""
    constant_bias: Vector = NONE
    """Known, not drawn; in B's unit."""
    scale: Vector = NONE
    """Relative scale error by axis."""
    misalignment: Vector = NONE
    """Rotation vector from the base's axes to the sensor's, rad."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "bias_instability")
        require(self, "correlation_time", above_zero=True, infinite=True)
        if self.turn_on_bias is not None:
            require(self, "turn_on_bias")
        for name in ("constant_bias", "scale", "misalignment"):
            object.__setattr__(self, name, _vector(name, getattr(self, name)))

    @property
    @abstractmethod
    def random_walk(self) -> float:
        """`N`: std of the integrated white noise after one second."""

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Rate samples, each the mean over the `dt` seconds before it."""
        white, turn_on, drift = random.spawn(3)
        B = self.bias_instability
        start = B if self.turn_on_bias is None else self.turn_on_bias
        bias = gaussian(turn_on, (1, 3), start) + np.array(self.constant_bias)
        R_BS = Rotation.from_rotvec(self.misalignment).as_matrix()
        return (
            (1 + np.array(self.scale)) * (true @ R_BS)
            + bias
            + bias_drift(drift, true.shape, B, self.correlation_time, dt)
            + random_walk_rate(white, true.shape, self.random_walk, dt)
        )


@dataclass(frozen=True, kw_only=True)
class Gyro(InertialSensor):
    """Angular rate of the base, base axes, rad/s."""

    angle_random_walk: float = 0.0
    """`N`, rad/sqrt(s)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "angle_random_walk")

    @property
    def random_walk(self) -> float:
        """`N`, rad/sqrt(s)."""
        return self.angle_random_walk


@dataclass(frozen=True, kw_only=True)
class Accelerometer(InertialSensor):
    """Specific force at S, base axes, m/s^2; in free fall that is S's acceleration."""

    velocity_random_walk: float = 0.0
    """`N`, m/s/sqrt(s)."""
    increments: bool = False
    """Whether it gives velocity increments, m/s, instead of samples."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "velocity_random_walk")

    @property
    def random_walk(self) -> float:
        """`N`, m/s/sqrt(s)."""
        return self.velocity_random_walk

    def read_increments(
        self, true: Float[np.ndarray, "n 7"], dt: float, random: np.random.Generator
    ) -> Float[np.ndarray, "n 3"]:
        """Velocity increments since the sample before; NaN for the first.

        Args:
            true: attitude (quaternion) and velocity of S (inertial axes, m/s).
            dt: from one sample to the next, s.
            random: the sensor's stream.
        """
        mean_force = velocity_increments(true[:, :4], true[:, 4:]) / dt
        return dt * self.read(mean_force, dt, random)


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


def _vector(name: str, value: object) -> Vector:
    try:
        x, y, z = (float(each) for each in np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        x = y = z = np.nan
    if not np.isfinite([x, y, z]).all():
        raise InputError(f"{name}: found {value!r}; give three finite numbers, in SI")
    return x, y, z
