"""What the regressors need of a recording, sample by sample, without copying it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.model.core_robot import wheels_of
from orbident.preprocessing.base_motion import (
    base_motion,
    point_velocity,
    with_first_attitude,
)
from orbident.preprocessing.delays import delays
from orbident.preprocessing.followers import one_motion
from orbident.preprocessing.histories import (
    Columns,
    Lead,
    Range,
    held_joints,
    histories,
)
from orbident.preprocessing.integrals import bias_response
from orbident.preprocessing.origins import BIASED, Origin
from orbident.preprocessing.rate_noise import RateNoise, least_speed_noise
from orbident.preprocessing.smoothing import Settings
from orbident.preprocessing.wrenches import (
    RecordedWrench,
    Surroundings,
    recorded_wrenches,
    surroundings,
)
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


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
    h_given: Float[np.ndarray, "n 3"]
    """What acted from outside has given to the angular momentum, N m s."""


class OutsideMomentum(NamedTuple):
    """What acted from outside has given to the momenta since the first row."""

    t: Float[np.ndarray, " nodes"]
    """s."""
    h: Float[np.ndarray, "nodes 3"]
    """To the angular momentum about the system CM, inertial axes, N m s."""
    v: Float[np.ndarray, "nodes 3"]
    """To the velocity of the system CM, inertial axes, m/s."""


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
    """Velocity of S, inertial axes, m/s; empty where it cannot be had."""
    wrenches: tuple[RecordedWrench, ...]
    """What is known to act on the base."""
    surroundings: Surroundings
    """What is known of `nadir`, `flow`, `sun` and `field`."""
    locked: tuple[str, ...]
    """Joints that did not move: held at their mean, with zero rate."""
    led: Mapping[str, Lead]
    """Joints whose encoders show no motion of their own, and what moves them."""
    shares: tuple[float, ...]
    """Variance of each joint's smoothed position over that of a sample; NaN where the
    rate was measured."""
    worst: tuple[tuple[float, float], ...]
    """The largest deviations of each joint's smoothed position, rad or m, and rate, per
    second; zero where they are not known."""
    origins: dict[str, Origin]
    """How joint rates, wheel speeds and the velocity of S were obtained."""
    source: str
    """Where the recording came from, for messages."""
    speeds: tuple[RateNoise, ...] = ()
    """Noise of each wheel's speed; none where its angle was recorded."""
    pushed: tuple[float, float] | None = None
    """From when to when something pushed the robot, s, where that is known."""
    h_given: Columns = ()
    """Angular momentum that was given from outside so far, inertial axes, N m s, where
    that is known: `v_S` is then without what was given to the CM's velocity."""

    def batches(self, size: int) -> Iterator[Batch]:
        """All samples in batches of this size; the last one is what remains."""
        for start in range(0, self.t.size, size):
            yield self.batch(start, size)

    def first(self) -> Batch | None:
        """The first sample that is valid, alone; None where there is none."""
        size = 1024
        for k, batch in enumerate(self.batches(size)):
            if batch.turning.any():
                return self.batch(k * size + int(batch.turning.argmax()), 1)
        return None

    def complete(self) -> tuple[Float[np.ndarray, " n"], Batch]:
        """Times, s, and all that was measured then: valid samples only."""
        everything = self.batch(0, self.t.size)
        valid = everything.turning
        return self.t[valid], Batch(*(part[valid] for part in everything))

    def configurations(self, count: int) -> Float[np.ndarray, "n joints"]:
        """Joint positions at `count` valid samples, evenly spaced; all if fewer."""
        valid = np.ones(self.t.size, dtype=bool)
        for column in (*self.q, *self.qd, *self.w, *self.x_WB, *self.qd_rw):
            valid &= np.isfinite(column)
        rows = np.flatnonzero(valid)
        which = np.linspace(0, rows.size - 1, count).round().astype(int)
        rows = rows[np.unique(which)]
        return np.reshape([column[rows] for column in self.q], (-1, rows.size)).T

    def batch(self, start: int, size: int) -> Batch:
        """The samples from `start` on, at most `size` of them."""
        rows = slice(start, min(start + size, self.t.size))
        names = ("q", "qd", "w", "x_WB", "qd_rw", "v_S")
        tables = [_table(getattr(self, name), rows) for name in names]
        complete = [np.isfinite(table).all(axis=1) for table in tables]
        turning = np.logical_and.reduce(complete[:5])
        moving = turning & complete[5] & self.tracked
        q, qd, w, x_WB, qd_rw, v_S = (
            np.where(turning[:, None], table, 0.0) for table in tables
        )
        x_WB[~turning, 3] = 1.0
        unknown = np.zeros((turning.size, 3))
        v_S = np.where(moving[:, None], v_S if self.tracked else unknown, unknown)
        h_given = _table(self.h_given, rows) if self.h_given else unknown
        return Batch(q, qd, w, x_WB, qd_rw, v_S, turning, moving, h_given)

    @property
    def unknown_thrust(self) -> bool:
        """Whether thrust acts of whose momentum nothing is known yet."""
        return bool(self.wrenches) and not self.h_given

    def without(self, given: OutsideMomentum) -> "Samples":
        """The samples of the same motion without what acts from outside.

        Those while something pushes are left out.
        """

        def at_samples(x: Float[np.ndarray, "nodes 3"]) -> Columns:
            return tuple(np.interp(self.t, given.t, column) for column in x.T)

        begin, end = self.pushed or (np.inf, -np.inf)
        # How a push acts while it lasts is known in outline only.
        lasting = (self.t >= begin) & (self.t <= end)
        w = tuple(np.where(lasting, np.nan, column) for column in self.w)
        v_S = (
            own - more for own, more in zip(self.v_S, at_samples(given.v), strict=False)
        )
        return replace(self, w=w, v_S=tuple(v_S), h_given=at_samples(given.h))

    @property
    def tracked(self) -> bool:
        """Whether the velocity of S can be had; without it `pi` alone shows."""
        return bool(self.v_S)

    @property
    def biased(self) -> bool:
        """Whether the bias of an accelerometer shows in `v_S`."""
        return self.tracked and bool(self.origins.get("velocity", Origin(0)) & BIASED)

    def drift(self) -> Float[np.ndarray, "samples 3 3"] | None:
        """What that bias adds to `v_S`, inertial axes, s; None where it does not show.

        It is as large as all else, and is worked out each time.
        """
        if not self.biased:
            return None
        x = np.column_stack(self.x_WB)
        known = np.isfinite(x).all(axis=1)
        if known.all():
            return bias_response(self.t, x)
        drift = np.zeros((self.t.size, 3, 3))
        drift[known] = bias_response(self.t[known], x[known])
        return drift


def samples_of(
    robot: Robot,
    recording: Recording,
    late: Mapping[str, float] | None = None,
    settings: Settings | None = None,
) -> Samples:
    """Take what identification needs from a recording, and derive what is missing.

    A row counts where the base rate is measured; all else is filled in between its own
    samples, so that every sensor may have its own rate.

    Args:
        robot: with the noise of its sensors, where that is known.
        recording: joint and wheel positions, and gyro or attitude, at least.
        late: by sensor, by how much its times are behind the gyro's, s, beside what
            the robot file declares; none where absent.
        settings: of the whole recording; where absent, this is the whole.

    Raises:
        InputError: a joint or wheel column, or gyro and attitude, are missing, or one
            names a joint or wheel that the robot does not have.
    """
    recording = recording.with_joints_of(robot)
    recording.check_wheels(robot)
    recording.check_thrusters(robot)
    recording.check_torquers(robot)
    behind = delays(robot, recording, late or {})
    settings = settings or Settings()
    joints = histories(
        recording,
        "joint",
        robot.joint_names,
        "velocity",
        robot.sensors.joints,
        behind["joints"],
        settings,
    )
    wheels = histories(
        recording,
        "wheel",
        robot.wheel_names,
        "speed",
        robot.sensors.wheels,
        behind["wheels"],
        settings,
        least_speed_noise(robot) if recording.has_vector("gyro") else 0.0,
    )
    base = base_motion(recording, robot.sensors, behind["attitude"], settings)
    point = point_velocity(recording, base.x_WB, behind, settings)
    around = surroundings(robot, recording, base.x_WB)
    held = settings.locked
    if held is None:
        q, qd = Range.of(joints.positions), Range.of(joints.rates)
        held = held_joints(robot, q, qd, float(np.median(np.diff(recording.t))))
    # However little a joint does, it moves with those that follow it.
    led = settings.once("followers", partial(one_motion, robot, recording))
    head = {name: led[name].by if name in led else name for name in robot.joint_names}
    moving = {head[name] for name in robot.joint_names if name not in held}
    held = {name: x for name, x in held.items() if head[name] not in moving}
    joints = joints.held(held, robot.joint_names).led(led, robot.joint_names)
    x_WB, gyro_alone = base.x_WB, base.origins["attitude"] is Origin.INTEGRATED_GYRO
    seen = bool(point.v_S) and not point.origin & BIASED
    if robot.motion == "spatial" and gyro_alone and seen:
        # Nobody saw the attitude, and S was seen in inertial axes of any kind.
        x_WB = with_first_attitude(
            robot, joints.positions, joints.rates, base.w, x_WB, point.v_S
        )
    return Samples(
        t=recording.t,
        q=joints.positions,
        qd=joints.rates,
        w=base.w,
        x_WB=x_WB,
        qd_rw=wheels.rates,
        v_S=point.v_S,
        wrenches=recorded_wrenches(robot, recording, around),
        surroundings=around,
        locked=tuple(held),
        led=led,
        shares=joints.shares,
        worst=joints.worst,
        origins={
            "joint_rates": joints.origin,
            "wheel_speeds": wheels.origin,
            **base.origins,
            "velocity": point.origin,
        },
        source=recording.source,
        speeds=wheels.noise,
    )


def _table(columns: Columns, rows: slice) -> Float[np.ndarray, "n k"]:
    table = np.empty((rows.stop - rows.start, len(columns)))
    for k, column in enumerate(columns):
        table[:, k] = column[rows]
    return table


def wheels_momentum(robot: Robot, samples: Samples) -> Float[np.ndarray, "n 3"]:
    """That of all wheels beside the base, base axes, N m s."""
    qd_rw = np.reshape(samples.qd_rw, (len(robot.wheels), samples.t.size))
    return qd_rw.T @ wheels_of(robot).A_rw.T
