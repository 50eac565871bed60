"""What the regressors need of a recording, sample by sample, without copying it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.signals.rates import fill, spline_rates

Columns = tuple[Float[np.ndarray, " samples"], ...]

LOCKED = 1e-3
"""A joint that moved less (rad or m) did not move: encoders are finer than that."""

MEASURED = "measured"
DERIVED = "derived: cubic spline through the positions"


class Batch(NamedTuple):
    """Some consecutive samples, side by side; those not valid hold zeros."""

    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    w: Float[np.ndarray, "n 3"]
    x_WB: Float[np.ndarray, "n 4"]
    qd_rw: Float[np.ndarray, "n wheels"]
    v_S: Float[np.ndarray, "n 3"]
    turning: Bool[np.ndarray, " n"]
    """Whether all that the momentum equation needs was measured."""
    moving: Bool[np.ndarray, " n"]
    """Whether the velocity of S was measured too."""


@dataclass(frozen=True)
class Samples:
    """A recording's columns in the robot's order, with what was missing derived."""

    t: Float[np.ndarray, " samples"]
    q: Columns
    qd: Columns
    w: Columns
    x_WB: Columns
    qd_rw: Columns
    v_S: Columns
    """Of S, inertial axes, m/s; empty where it cannot be had."""
    locked: tuple[str, ...]
    """Joints that did not move: held at their mean, with zero rate."""
    origins: dict[str, str]
    """How joint rates, wheel speeds and the velocity of S were obtained."""
    source: str
    """Where the recording came from, for messages."""

    def batches(self, size: int) -> Iterator[Batch]:
        """All samples in batches of this size, the last one padded."""
        for start in range(0, self.t.size, size):
            yield self.batch(start, size)

    def first(self) -> Batch | None:
        """The first sample that is valid, alone; None where there is none."""
        size = 1024
        for k, batch in enumerate(self.batches(size)):
            if batch.turning.any():
                return self.batch(k * size + int(batch.turning.argmax()), 1)
        return None

    def batch(self, start: int, size: int) -> Batch:
        """The samples from `start` on, padded to `size` where the recording ends."""
        names = ("q", "qd", "w", "x_WB", "qd_rw", "v_S")
        tables = [_table(getattr(self, name), start, size) for name in names]
        complete = [np.isfinite(table).all(axis=1) for table in tables]
        turning = np.logical_and.reduce(complete[:5])
        turning &= np.arange(start, start + size) < self.t.size
        moving = turning & complete[5] & bool(self.v_S)
        q, qd, w, x_WB, qd_rw, v_S = (
            np.where(turning[:, None], table, 0.0) for table in tables
        )
        x_WB[~turning, 3] = 1.0
        unknown = np.zeros((size, 3))
        v_S = np.where(moving[:, None], v_S if self.v_S else unknown, unknown)
        return Batch(q, qd, w, x_WB, qd_rw, v_S, turning, moving)


def samples_of(robot: Robot, recording: Recording) -> Samples:
    """Take what identification needs from a recording.

    Gaps in joint and wheel columns are filled by splines, so that these may have
    their own rates; a sample counts where gyro and attitude were both measured.

    Raises:
        InputError: a joint, wheel, gyro or attitude column is missing, or one names a
            joint or wheel that the robot does not have.
    """
    recording.check_joints(robot)
    recording.check_wheels(robot)
    positions, rates, joint_origin = _positions_and_rates(
        recording, "joint", robot.joint_names, "velocity"
    )
    _, wheel_speeds, wheel_origin = _positions_and_rates(
        recording, "wheel", robot.wheel_names, "speed"
    )
    v_S, velocity_origin = _velocity(recording)
    still = [np.nanmax(q) - np.nanmin(q) < LOCKED for q in positions]
    zero = np.zeros(recording.t.size if any(still) else 0)
    return Samples(
        t=recording.t,
        q=tuple(
            np.full_like(q, np.nanmean(q)) if locked else q
            for q, locked in zip(positions, still, strict=True)
        ),
        qd=tuple(
            zero if locked else qd for qd, locked in zip(rates, still, strict=True)
        ),
        w=_vector(recording, "gyro", "xyz"),
        x_WB=_vector(recording, "attitude", "xyzw"),
        qd_rw=wheel_speeds,
        v_S=v_S,
        locked=tuple(
            name
            for name, locked in zip(robot.joint_names, still, strict=True)
            if locked
        ),
        origins={
            "joint_rates": joint_origin,
            "wheel_speeds": wheel_origin,
            "velocity": velocity_origin,
        },
        source=recording.source,
    )


def _table(columns: Columns, start: int, size: int) -> Float[np.ndarray, "size k"]:
    table = np.zeros((size, len(columns)))
    for k, column in enumerate(columns):
        part = column[start : start + size]
        table[: part.size, k] = part
    return table


def _vector(recording: Recording, sensor: str, components: str) -> Columns:
    return tuple(recording.column(f"{sensor}.{k}") for k in components)


def _without_gaps(recording: Recording, name: str) -> Float[np.ndarray, " samples"]:
    column = recording.column(name)
    if np.isnan(column).any():
        return fill(recording.t, column, f"{recording.source}: column '{name}'")
    return column


def _derived(recording: Recording, name: str) -> Float[np.ndarray, " samples"]:
    label = f"{recording.source}: column '{name}'"
    return spline_rates(recording.t, recording.column(name), label)


def _positions_and_rates(
    recording: Recording, what: str, names: Sequence[str], rate: str
) -> tuple[Columns, Columns, str]:
    positions, rates, origins = [], [], set()
    for name in names:
        position, measured = f"{what}.{name}.position", f"{what}.{name}.{rate}"
        if recording.has(position):
            positions.append(_without_gaps(recording, position))
        if recording.has(measured):
            rates.append(_without_gaps(recording, measured))
            origins.add(MEASURED)
        else:
            rates.append(_derived(recording, position))
            origins.add(DERIVED)
    return tuple(positions), tuple(rates), "; ".join(sorted(origins)) or "none"


def _velocity(recording: Recording) -> tuple[Columns, str]:
    if recording.has("velocity.x", "velocity.y", "velocity.z"):
        return _vector(recording, "velocity", "xyz"), MEASURED
    if recording.has("position.x", "position.y", "position.z"):
        return tuple(_derived(recording, f"position.{k}") for k in "xyz"), DERIVED
    return (), "missing"
