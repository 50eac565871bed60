"""What real instruments, gears and spacecraft do, from just visible to gross.

Sizes are those of data sheets and of laboratories; where two are given, the smaller one
is what a good instrument has.
"""

from collections.abc import Callable

import numpy as np
from edited_recordings import changed
from mistake import IN_SPACE, ON_TABLE, Groups, Mistake
from recordings import SEED, Clean, motion_of
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import Change, columns, drift, quaternion, vector
from wrong_sensors import clock

from orbident.recordings.recording import Recording


def in_time(start: str, added: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """Every column that begins so has something added that goes with the time."""

    def spoil(clean: Clean) -> Spoiled:
        return columns(start, lambda column: column + added(clean.t))(clean)

    return spoil


def low_passed(start: str, time: float) -> Spoil:
    """A filter of first order with this time constant, s, as drives and gyros have."""

    def spoil(clean: Clean) -> Spoiled:
        keep = np.exp(-(clean.t[1] - clean.t[0]) / time)

        def change(column: np.ndarray) -> np.ndarray:
            out = column.copy()
            for k in range(1, out.size):
                out[k] = keep * out[k - 1] + (1 - keep) * column[k]
            return out

        return columns(start, change)(clean)

    return spoil


def averaged(start: str, rows: int) -> Spoil:
    """The mean of so many rows around each: a pose that comes out of a smoother."""

    def change(column: np.ndarray) -> np.ndarray:
        padded = np.pad(column, rows // 2, mode="edge")
        return np.convolve(padded, np.full(rows, 1 / rows), "valid")[: column.size]

    return columns(start, change)


def ripple(size: float, a_turn: float) -> Change:
    """An error with a period in the joint's own angle; rad, periods a turn."""
    return lambda q: q + size * np.sin(a_turn * q)


def backlash(width: float) -> Change:
    """The motor's angle is ahead of the link by half the play, in either direction."""

    def change(q: np.ndarray) -> np.ndarray:
        out, at = np.empty_like(q), q[0]
        for k, motor in enumerate(q):
            at = min(max(at, motor - width / 2), motor + width / 2)
            out[k] = q[k] + (q[k] - at)
        return out

    return change


def rounded(step: float) -> Change:
    return lambda column: step * np.round(column / step)


def saturated(part: float) -> Change:
    """Clipped at this part of what would be the largest."""

    def change(column: np.ndarray) -> np.ndarray:
        most = part * np.abs(column).max()
        return np.clip(column, -most, most)

    return change


def lasting(start: str, size: float, time: float) -> Spoil:
    """An error that lasts: of first order (Gauss, Markov)."""
    random = np.random.default_rng(SEED)

    def spoil(clean: Clean) -> Spoiled:
        keep = np.exp(-(clean.t[1] - clean.t[0]) / time)

        def change(column: np.ndarray) -> np.ndarray:
            e = size * random.standard_normal(column.size)
            for k in range(1, e.size):
                e[k] = keep * e[k - 1] + np.sqrt(1 - keep**2) * e[k]
            return column + e

        return columns(start, change)(clean)

    return spoil


def lasting_attitude(angle: float, time: float) -> Spoil:
    """As a star tracker's, about the base's z; rad."""

    def spoil(clean: Clean) -> Spoiled:
        keep = np.exp(-(clean.t[1] - clean.t[0]) / time)
        e = angle * np.random.default_rng(SEED).standard_normal(clean.t.size)
        for k in range(1, e.size):
            e[k] = keep * e[k - 1] + np.sqrt(1 - keep**2) * e[k]
        return quaternion(
            lambda x: (
                Rotation.from_quat(x) * Rotation.from_euler("z", e[:, None])
            ).as_quat()
        )(clean)

    return spoil


def markers_swap(angle: float, part: float) -> Spoil:
    """Degrees: for this part of the time a tracker takes one marker for another."""

    def change(x: np.ndarray) -> np.ndarray:
        row = np.arange(len(x)) / len(x)
        off = angle * ((row > 0.4) & (row < 0.4 + part))
        turned = Rotation.from_euler("z", off[:, None], degrees=True)
        return (Rotation.from_quat(x) * turned).as_quat()

    return quaternion(change)


def euler_rates(clean: Clean) -> Spoiled:
    """Rates of roll, pitch and yaw under the names of body rates."""
    recording = clean.recorded()
    angles = Rotation.from_quat(clean.true.attitude).as_euler("ZYX")[:, ::-1]
    rates = np.gradient(np.unwrap(angles, axis=0), clean.t, axis=0)
    new = {f"gyro.{k}": rates[:, i].copy() for i, k in enumerate("xyz")}
    return spoiled(clean, recording=changed(recording, new))


def late_fixes(part: float) -> Spoil:
    """Each position was taken up to this long before its row, s: a network's delay."""

    def spoil(clean: Clean) -> Spoiled:
        late = part * np.random.default_rng(SEED).random(clean.t.size)
        at = np.maximum.accumulate(np.maximum(clean.t - late, 0.0))
        at = at + 1e-9 * np.arange(at.size)
        seen = motion_of(clean.robot, clean.joints, clean.start, at)
        true = clean.true._replace(position=seen.position)
        return spoiled(clean, recording=clean.recorded(true))

    return spoil


def tachometer(offset: float) -> Spoil:
    """Wheels are known by their speeds alone, and these are off; rad/s."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        new = {
            name: column
            for name, column in recording.columns.items()
            if not name.startswith("wheel.")
        }
        for k, name in enumerate(clean.robot.wheel_names):
            new[f"wheel.{name}.velocity"] = clean.true.qd_rw[:, k] + offset
        return spoiled(clean, recording=Recording(recording.t, new))

    return spoil


def skewed(angle: float) -> np.ndarray:
    """Axes that are not at right angles, rad."""
    return np.array([[1.0, angle, 0.0], [0.0, 1.0, -angle], [angle, 0.0, 1.0]])


def twice(name: str, make: Callable[[float], Spoil], *sizes: float, **more) -> tuple:
    """One kind in several sizes; `name` has the place of the size."""
    said = more.pop("cause")
    return tuple(Mistake(name.format(size), make(size), said, **more) for size in sizes)


EFFECTS: Groups = {
    "gear": (
        *twice("gear ripple of {:g} rad, 200 a turn",
               lambda size: columns("joint.joint2", ripple(size, 200.0)),
               5e-4, 5e-3, cause="noise|ripple|scale|zero|lasting joint"),
        *twice("encoder off centre by {:g} rad",
               lambda size: columns("joint.joint2", ripple(size, 1.0)),
               1e-3, 1e-2, cause="zero|scale|centre|ripple|drift* joint2",
               unobservable=ON_TABLE),
        *twice("backlash of {:g} rad",
               lambda size: columns("joint.joint2", backlash(size)),
               1e-3, 1e-2, cause="backlash|slip*|flexib*|noise|late|clock|jump* joint"),
        *twice("zero of joint2 drifts {:g} rad/s",
               lambda size: drift("joint.joint2", size),
               2e-5, 1e-3, cause="drift* joint2"),
        *twice("drive's filter on all joints, {:g} s",
               lambda size: low_passed("joint.", size),
               0.02, 0.3, cause="late|clock|delay*|filter*|flexib* joint"),
    ),
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
    ),
    "tracker": (
        *twice("star tracker's lasting error of {:g} rad over 10 s",
               lambda size: lasting_attitude(size, 10.0), 1e-4, 2e-3,
               cause="noise|lasting|drift*|jump* attitude"),
        *twice("motion capture's lasting error of {:g} m over 5 s",
               lambda size: lasting("position.", size, 5.0), 3e-4, 5e-3,
               cause="noise|lasting|drift*|jump* position"),
        *twice("markers swapped for 10 % of the time, {:g} deg",
               lambda size: markers_swap(size, 0.1), 0.3, 5.0,
               cause="jump*|outlier|swap*|spike|step attitude"),
        *twice("poses from a smoother of {:g} rows",
               lambda size: averaged("position.", int(size)), 5.0, 51.0,
               cause="noise|smooth*|filter* position"),
        *twice("positions from a filter of {:g} s",
               lambda size: low_passed("position.", size), 0.05, 0.5,
               cause="late|clock|delay*|filter* position"),
        *twice("positions up to {:g} s late, each for itself", late_fixes, 0.01, 0.1,
               cause="late|clock|delay*|jitter|noise position"),
        *twice("position rounded to {:g} m",
               lambda size: columns("position.", rounded(size)), 1e-3, 2e-2,
               cause="noise|round*|resol*|step|quanti* position"),
        *twice("mast that swings the marker by {:g} m at 0.7 Hz",
               lambda size: in_time("position.x",
                                    lambda t: size * np.sin(1.4 * np.pi * t)),
               5e-4, 1e-2, cause="noise|vibrat*|swing*|flexib* position"),
    ),
    "encoder": (
        *twice("encoders rounded to {:g} rad",
               lambda size: columns("joint.", rounded(size)), 1e-3, 1e-2,
               cause="noise|round*|resol*|step|quanti* joint"),
        *twice("tachometers off by {:g} rad/s", tachometer, 0.05, 2.0,
               cause="offset|zero|tacho*|speed|rest wheel"),
    ),
}  # fmt: skip
