"""What gyros do, from just visible to gross."""

from collections.abc import Callable

import numpy as np
from edited_recordings import changed
from mistake import IN_SPACE, Groups, Mistake, twice
from recordings import Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import Change, columns, in_time, low_passed, rounded, vector
from wrong_sensors import clock


def saturated(part: float) -> Change:
    """Clipped at this part of what would be the largest."""

    def change(column: np.ndarray) -> np.ndarray:
        most = part * np.abs(column).max()
        return np.clip(column, -most, most)

    return change


def euler_rates(clean: Clean) -> Spoiled:
    """Rates of roll, pitch and yaw under the names of body rates."""
    recording = clean.recorded()
    angles = Rotation.from_quat(clean.true.attitude).as_euler("ZYX")[:, ::-1]
    rates = np.gradient(np.unwrap(angles, axis=0), clean.t, axis=0)
    new = {f"gyro.{k}": rates[:, i].copy() for i, k in enumerate("xyz")}
    return spoiled(clean, recording=changed(recording, new))


def skewed(angle: float) -> np.ndarray:
    """Axes that are not at right angles, rad."""
    return np.array([[1.0, angle, 0.0], [0.0, 1.0, -angle], [angle, 0.0, 1.0]])


def by_sign(part: float) -> Change:
    """Rates that are negative are so much too large."""
    return lambda rate: rate * np.where(rate < 0, 1 + part, 1.0)


def quadratic(part: float) -> Change:
    """So much too large at the largest rate, and less in proportion below."""
    return lambda rate: rate * (1 + part * np.abs(rate) / np.abs(rate).max())


def shown(field: Callable[[Clean], np.ndarray]) -> Spoil:
    """The gyro shows other rates, rad/s, and its own noise."""

    def spoil(clean: Clean) -> Spoiled:
        true = clean.true._replace(gyro=field(clean))
        return spoiled(clean, recording=clean.recorded(true))

    return spoil


def means(clean: Clean) -> np.ndarray:
    """Increments of the angle over a row by its length: half a row late."""
    R = Rotation.from_quat(clean.true.attitude)
    turned = (R[:-1].inv() * R[1:]).as_rotvec() / np.diff(clean.t)[:, None]
    return np.vstack([clean.true.gyro[:1], turned])


def felt(size: float) -> Spoil:
    """Acceleration shifts the zero, rad/s over m/s^2."""
    return shown(lambda clean: clean.true.gyro + size * clean.true.accelerometer)


OF_GYROS: Groups = {
    "gyro": (
        *twice("gyro low-passed, {:g} s",
               lambda size: low_passed("gyro.", size), 0.02, 0.3,
               cause="late|clock|delay*|filter* gyro", robots=IN_SPACE),
        *twice("gyro clipped at {:g} of its largest",
               lambda size: columns("gyro.", saturated(size)), 0.95, 0.6,
               cause="clip*|satur* gyro", robots=IN_SPACE),
        *twice("gyro skewed by {:g} rad",
               lambda size: vector("gyro", skewed(size)), 1e-3, 1e-2,
               cause="misalign*|scale|skew*|axes gyro", robots=IN_SPACE),
        *twice("gyro shaken by {:g} rad/s at 3 Hz",
               lambda size: in_time("gyro.", lambda t: size * np.sin(6 * np.pi * t)),
               1e-4, 3e-3, cause="noise|vibrat* gyro", robots=IN_SPACE),
        *twice("gyro bias follows the temperature by {:g} rad/s",
               lambda size: in_time("gyro.x", lambda t: size * (1 - np.exp(-t / 30))),
               1e-4, 1e-3, cause="bias|drift* gyro", robots=IN_SPACE),
        Mistake("gyro shows rates of Euler angles", euler_rates,
                "euler|axes|inertial|frame gyro", IN_SPACE),
        Mistake("clock of the gyro 1 % fast", clock("gyro", 0.0, 1.01),
                "clock gyro", IN_SPACE),
        *twice("gyro {:g} too large where it is negative",
               lambda size: columns("gyro.", by_sign(size)), 1e-3, 2e-2,
               cause="scale|sign|asymmetr* gyro", robots=IN_SPACE),
        *twice("gyro {:g} too large at its largest rate, less below",
               lambda size: columns("gyro.", quadratic(size)), 1e-3, 2e-2,
               cause="scale|linear*|quadratic gyro", robots=IN_SPACE),
        *twice("gyro shifted by {:g} rad/s over m/s^2", felt, 2e-3, 5e-2,
               cause="bias|acceler*|drift*|lasting|noise gyro", robots=IN_SPACE),
        *twice("gyro rounded to {:g} rad/s",
               lambda size: columns("gyro.", rounded(size)), 1e-4, 3e-3,
               cause="noise|round*|resol*|step|quanti*|repeat*|stuck gyro",
               robots=IN_SPACE),
        Mistake("gyro shows the mean since its last row", shown(means),
                "late|clock|delay*|filter* gyro", IN_SPACE),
    ),
}  # fmt: skip
