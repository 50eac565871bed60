"""Noise of the rates of joints and wheels, and what it adds to the base's rate."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.gaussian import white_std_of
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia_at
from orbident.robot.description import Robot

HIDDEN = 0.5
"""Noise of wheels' speeds that turns the base by less than this part of the gyro's own
noise is hidden by it: the variance grows by an eighth at most."""

FINER = 0.1
"""Part of an attitude's noise by which a gyro walks at most until the next attitude.
Attitudes that are as fine as the gyro show by themselves how noise turns the base: with
1 deg/sqrt(h) beside 0.02 deg deviations did not hold it, and with 0.3 deg/sqrt(h) they
did."""

TABLED, FEWEST, MOST = 2**18, 8, 72
"""Rows of a recording times waves of the noise of a wheel's speed, as each is a table
of all rows; and how many waves. Fewer hold nothing of a motion. So many hold what
smoothing leaves of a wheel that speeds up and slows down within half a minute."""

ORDER = 8
"""The noise of a rate is taken from its differences of this order, which hold hardly
any motion: of a sine at an eighth of the rate of rows they are a thousandth."""

ROUNDED = 1e-6
"""Part of what a rate varies by, below which it has no noise: float32, and what these
differences leave of a motion at a twentieth of the rate of rows."""


def waves_of_noise(rows: int) -> int:
    """How many waves of the noise of a wheel's speed a fit has among its unknowns."""
    waves = min(MOST, TABLED // rows)
    return waves if waves >= FEWEST else 0


class RateNoise(NamedTuple):
    """Noise of a tachometer in a rate that it alone tells."""

    density: float
    """Density of the waves that stand for it in a fit, rad/s/sqrt(Hz); zero where a
    recording is too long for waves, or the gyro's noise hides them."""
    white: float
    """Std of a sample that is used as it was read, rad/s; zero where speeds are
    smoothed."""

    @classmethod
    def read(
        cls, std: float, t: Float[np.ndarray, " samples"], samples: int, shows: float
    ) -> "RateNoise":
        """Noise of a tachometer whose speeds are used as they are read.

        Args:
            std: of a sample, rad/s.
            t: times of rows, s.
            samples: how many of them have one.
            shows: density from which on it shows in the base's rate, rad/s/sqrt(Hz).
        """
        density = float(std * np.sqrt((t[-1] - t[0]) / samples))
        waves = waves_of_noise(t.size) and density >= shows
        return cls(density if waves else 0.0, std)

    @classmethod
    def undeclared(cls, column: Float[np.ndarray, " samples"]) -> "RateNoise":
        """Noise of a rate that is used as it was read, as its column shows it.

        Args:
            column: rad/s; NaN where there is no sample.
        """
        rate = column[np.isfinite(column)]
        if rate.size <= ORDER:
            return cls(0.0, 0.0)
        std = float(white_std_of(np.diff(rate, n=ORDER), ORDER))
        return cls(0.0, std if std > ROUNDED * float(rate.std()) else 0.0)


NO_NOISE = RateNoise(0.0, 0.0)


def momentum_noise(
    robot: Robot, speeds: Sequence[RateNoise]
) -> Float[np.ndarray, "3 wheels"]:
    """A root of the covariance of `h_rw`, N m s, by what is white in wheels' speeds."""
    return wheels_of(robot).A_rw * np.array([each.white for each in speeds] or 0.0)


def declared_rate_noise(robot: Robot) -> float:
    """Std of the predicted base rate by the declared noise of tachometers, rad/s.

    The speeds are those that the tachometers show, without smoothing.
    """
    wheels = robot.sensors.wheels
    noise = RateNoise(0.0, (wheels and wheels.tachometer) or 0.0)
    return rate_noise(robot, [noise] * len(robot.wheels))


def least_speed_noise(robot: Robot) -> float:
    """The least density of wheels' speed noise that the base shows, rad/s/sqrt(Hz).

    It is zero where attitudes may show any, and infinite where none turns the base. On
    a table it is infinite, too, where the gyro shows the noise of every row: then it
    says what the speeds are, and waves take several times as long.
    """
    wheels, rows = robot.sensors.wheels, robot.sensors.rows_per_second
    if wheels is None or not wheels.tachometer:
        return 0.0
    if robot.motion == "planar":
        shown = declared_rate_noise(robot)
        return np.inf if shown > robot.sensors.of("gyro").white_std(1 / rows) else 0.0
    gyro, attitude = robot.sensors.of("gyro"), robot.sensors.of("attitude")
    rate = attitude.rate or robot.sensors.rate
    walked = gyro.white_std() / np.sqrt(rate) if rate else np.inf
    if not walked <= FINER * attitude.white_std():
        return 0.0
    turned = rate_noise(robot, [RateNoise(0.0, 1.0)] * len(robot.wheels))
    return HIDDEN * gyro.white_std() / turned if turned else np.inf


def rate_noise(robot: Robot, speeds: Sequence[RateNoise]) -> float:
    """Std of the predicted base rate, rad/s: `dw = -D^-1 dh_rw` (Eq. 3).

    Root mean square of the axes about which momentum is conserved, with the nominal
    inertia at zero joint positions.
    """
    axes = list(robot.conserved_axes[0])
    D = inertia_at(robot, np.zeros(len(robot.joints))).D[np.ix_(axes, axes)]
    dw = np.linalg.solve(D, momentum_noise(robot, speeds)[axes])
    return float(np.linalg.norm(dw) / np.sqrt(len(axes)))
