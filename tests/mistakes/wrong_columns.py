"""Recordings whose columns hold something else than they should.

Columns are changed only where a sensor that does the same would show the same.
"""

from collections.abc import Callable, Sequence

import numpy as np
from edited_recordings import changed
from recordings import SEED, Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled

from orbident.model.rotations import quaternion_matrix
from orbident.recordings.recording import Recording

Change = Callable[[np.ndarray], np.ndarray]


def columns(start: str, change: Change) -> Spoil:
    """Every column whose name begins so."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        names = [name for name in recording.columns if name.startswith(start)]
        assert names, start
        new = {name: change(recording.columns[name]) for name in names}
        return spoiled(clean, recording=changed(recording, new))

    return spoil


def times(factor: float) -> Change:
    return lambda column: factor * column


def plus(offset: float) -> Change:
    return lambda column: column + offset


def vector(sensor: str, M: Sequence[Sequence[float]] | np.ndarray) -> Spoil:
    """A sensor's three components by a matrix."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        shown = recording.vector(sensor) @ np.asarray(M, dtype=float).T
        new = {f"{sensor}.{k}": shown[:, i].copy() for i, k in enumerate("xyz")}
        return spoiled(clean, recording=changed(recording, new))

    return spoil


def turned(axis: str, angle: float) -> np.ndarray:
    """A rotation matrix; degrees."""
    return Rotation.from_euler(axis, angle, degrees=True).as_matrix()


def quaternion(change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """The attitude's columns hold what `change` makes of scalar-last quaternions."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        shown = change(recording.vector("attitude", "xyzw"))
        new = {f"attitude.{k}": shown[:, i].copy() for i, k in enumerate("xyzw")}
        return spoiled(clean, recording=changed(recording, new))

    return spoil


def body_turned(axis: str, angle: float) -> Spoil:
    """Degrees. The attitude sensor's axes are not the base's: `R_WS = R_WB R_BS`."""
    R_BS = Rotation.from_euler(axis, angle, degrees=True)
    return quaternion(lambda x: (Rotation.from_quat(x) * R_BS).as_quat())


def world_turned(axis: str, angle: float) -> Spoil:
    """Degrees. Inertial axes that are not the position's: `R_VB = R_VW R_WB`."""
    R_VW = Rotation.from_euler(axis, angle, degrees=True)
    return quaternion(lambda x: (R_VW * Rotation.from_quat(x)).as_quat())


def first_wheel(change: Change) -> Spoil:
    """The one wheel on the table, or one of three."""
    return lambda clean: columns(f"wheel.{clean.robot.wheel_names[0]}.", change)(clean)


def in_inertial_axes(clean: Clean) -> Spoiled:
    """The gyro's samples, turned by the true attitude."""
    recording = clean.recorded()
    R_WB = quaternion_matrix(clean.true.attitude)
    w = np.einsum("nij,nj->ni", R_WB, recording.vector("gyro"))
    new = {f"gyro.{k}": w[:, i].copy() for i, k in enumerate("xyz")}
    return spoiled(clean, recording=changed(recording, new))


def exchanged(one: str, other: str) -> Spoil:
    """Two columns under each other's names."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        new = {one: recording.columns[other], other: recording.columns[one]}
        return spoiled(clean, recording=changed(recording, new))

    return spoil


def stamped(change: Change) -> Spoil:
    """Other times on the same rows."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        return spoiled(
            clean, recording=Recording(change(recording.t), recording.columns)
        )

    return spoil


def held(start: str, every: int, begin: float = 0.0, end: float = np.inf) -> Spoil:
    """Samples are repeated, from `begin` to `end`: one of so many is new."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        row = np.arange(clean.t.size)
        first = int(np.searchsorted(clean.t, begin))
        old = first + (row - first) // every * every
        source = np.where((clean.t >= begin) & (clean.t < end), old, row)
        new = {
            name: column[source]
            for name, column in recording.columns.items()
            if name.startswith(start)
        }
        return spoiled(clean, recording=changed(recording, new))

    return spoil


def rows_lost(begin: float, end: float) -> Spoil:
    """Rows are missing, and the times are closed up as if none were."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        left = (clean.t < begin) | (clean.t >= end)
        short = changed(recording, rows=left)
        return spoiled(
            clean, recording=Recording(recording.t[: short.t.size], short.columns)
        )

    return spoil


def outliers(column: str, part: float, size: float) -> Spoil:
    """Some samples are off by this much, each for itself."""

    def change(values: np.ndarray) -> np.ndarray:
        random = np.random.default_rng(SEED)
        bad = random.random(values.size) < part
        return values + np.where(bad, size * random.choice([-1.0, 1.0], bad.size), 0.0)

    return columns(column, change)


def jump(start: str, size: float) -> Spoil:
    """An offset from the middle on."""
    return columns(
        start,
        lambda column: column + size * (np.arange(column.size) >= column.size // 2),
    )


def attitude_jump(angle: float) -> Spoil:
    """About the base's z from the middle on, degrees."""

    def change(x: np.ndarray) -> np.ndarray:
        angles = angle * (np.arange(len(x)) >= len(x) // 2)
        return (
            Rotation.from_quat(x)
            * Rotation.from_euler("z", angles[:, None], degrees=True)
        ).as_quat()

    return quaternion(change)


def drift(start: str, rate: float) -> Spoil:
    """An offset that grows with time, a second."""

    def spoil(clean: Clean) -> Spoiled:
        return columns(start, lambda column: column + rate * clean.t)(clean)

    return spoil


def in_time(start: str, added: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """Every column that begins so has something added that goes with the time."""

    def spoil(clean: Clean) -> Spoiled:
        return columns(start, lambda column: column + added(clean.t))(clean)

    return spoil


def low_passed(start: str, time: float) -> Spoil:
    """A filter of first order with this time constant, s, as drives and gyros have."""
    return lambda clean: columns(start, filtered(clean.t, time))(clean)


def filtered(t: np.ndarray, time: float) -> Change:
    """A filter of first order for evenly spaced times; axes last."""
    keep = np.exp(-(t[1] - t[0]) / time)

    def change(column: np.ndarray) -> np.ndarray:
        out = column.copy()
        for k in range(1, len(out)):
            out[k] = keep * out[k - 1] + (1 - keep) * column[k]
        return out

    return change


def rounded(step: float) -> Change:
    return lambda column: step * np.round(column / step)
