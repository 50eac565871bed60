"""Pose from outside: star trackers, motion capture, vision.

Encoders of joints and wheels.
"""

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.model.rotations import quaternion_rate
from orbident.robot.sensor_suites import Coloured, PerAxis, coloured_noise
from orbident.simulation.noise_processes import coloured, gaussian, quantised
from orbident.simulation.sensor import Sensor, require


@dataclass(frozen=True, kw_only=True)
class Encoder(Sensor):
    """An angle (or, of a prismatic joint, a length), its rate, or both.

    `shown = resolution round((true + n) / resolution)`, `n ~ N(0, position^2)`. Wheels
    are counted over full turns. The paper's encoders show no rates (Section 3.5).

    Raises:
        InputError: a value is negative or not a number.
    """

    position: float | None = None
    """Std of the angle's noise, rad or m; None where only the rate is read."""
    resolution: float = 0.0
    """One count, rad or m; zero for a continuous reading."""
    tachometer: float | None = None
    """Std of the rate's noise, rad/s or m/s; None where no rate is read."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "resolution")
        for name in ("position", "tachometer"):
            if getattr(self, name) is not None:
                require(self, name)

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Angles, rad, or lengths, m; `dt` does not matter."""
        noisy = true + gaussian(random, true.shape, self.position or 0.0)
        return quantised(noisy, self.resolution)

    def read_rates(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Rates, rad/s or m/s; `dt` does not matter."""
        return true + gaussian(random, true.shape, self.tachometer or 0.0)


@dataclass(frozen=True, kw_only=True)
class Tracker(Sensor):
    """Noise that attitude and position share: white, and on each axis what lasts.

    Raises:
        InputError: a value is negative or not a number.
    """

    markov_std: PerAxis = 0.0
    """Std of a first-order Gauss-Markov process, rad or m."""
    correlation_time: PerAxis = 0.0
    """Correlation time of that process, s; above zero where there is one."""
    random_walk: PerAxis = 0.0
    """Density, rad/sqrt(s) or m/sqrt(s); the walk is zero at the first sample."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("markov_std", "correlation_time", "random_walk"):
            _require_axes(name, getattr(self, name))
        std, time = np.broadcast_arrays(self.markov_std, self.correlation_time)
        if ((std > 0) & (time == 0)).any():
            raise InputError(
                "correlation_time: give a time above zero, in s, beside markov_std"
            )

    @property
    def coloured(self) -> Coloured:
        """What is not white, by axis."""
        return coloured_noise({f.name: getattr(self, f.name) for f in fields(self)})

    def noise(
        self, n: int, std: float, dt: float, random: np.random.Generator
    ) -> Float[np.ndarray, "n 3"]:
        """The errors of samples `dt` apart, white and coloured."""
        white = gaussian(random, (n, 3), std)
        declared = self.coloured
        if declared.absent:
            return white
        return white + coloured(random, dt * np.arange(n), declared)


def _require_axes(name: str, value: object) -> None:
    """Refuse what is neither one number of zero or more nor three.

    Raises:
        InputError: so.
    """
    try:
        found = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.full(2, np.nan)
    if found.shape not in {(), (3,)} or not (np.isfinite(found) & (found >= 0)).all():
        raise InputError(
            f"{name}: found {value!r}; give a number of zero or more, or one for each "
            "of x, y, z, in SI"
        )


@dataclass(frozen=True, kw_only=True)
class AttitudeTracker(Tracker):
    """Orientation of the base in the inertial frame.

    `shown = true (x) exp(d / 2)`, with `d` the noise about each base axis: white with
    `angle` as its std, and what `Tracker` adds.

    Raises:
        InputError: a value is negative or not a number.
    """

    angle: float
    """Std of the white noise about each axis, rad."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "angle")

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Unit quaternions, scalar last, of attitudes `dt` seconds apart."""
        x_WB = true / np.linalg.norm(true, axis=1, keepdims=True)
        d = self.noise(len(true), self.angle, dt, random)
        half = np.linalg.norm(d, axis=1, keepdims=True) / 2
        # The product with (v, s) is s x + d/dt x at the rate 2 v; v = sin(half) d/|d|.
        v = np.sinc(half / np.pi) * d / 2
        return np.cos(half) * x_WB + quaternion_rate(x_WB, 2 * v)


@dataclass(frozen=True, kw_only=True)
class PositionTracker(Tracker):
    """Position of S in the inertial frame, m, with noise on each inertial axis.

    Raises:
        InputError: a value is negative or not a number.
    """

    std: float
    """Standard deviation of the white noise on each axis, m."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "std")

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Positions, m, `dt` seconds apart."""
        return true + self.noise(len(true), self.std, dt, random)
