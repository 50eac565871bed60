"""Kinds of mistakes in what the columns of a recording hold."""

import numpy as np
from drawn import Kind, Random, between, either, joint_of, middle
from edited_recordings import changed
from mistake import Mistake
from recordings import Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import (
    columns,
    exchanged,
    held,
    outliers,
    quaternion,
    rows_lost,
    stamped,
    times,
    vector,
)

DEGREES = 180 / np.pi


def two_joints_exchanged(clean: Clean, random: Random) -> Mistake:
    one, other = random.choice(clean.robot.joint_names, 2, replace=False)
    spoil = exchanged(f"joint.{one}.position", f"joint.{other}.position")
    words = f"exchang*|order|swap* {one} {other}"
    return Mistake(f"{one} and {other} exchanged", spoil, words)


def one_joint_in_degrees(clean: Clean, random: Random) -> Mistake:
    joint = joint_of(clean, random)
    spoil = columns(f"joint.{joint}.", times(DEGREES))
    return Mistake(f"{joint} in degrees", spoil, f"degree|deg {joint}")


def one_joint_negated(clean: Clean, random: Random) -> Mistake:
    joint = joint_of(clean, random)
    return Mistake(
        f"{joint} negated", columns(f"joint.{joint}.", times(-1)), f"sign {joint}"
    )


def two_joints_negated(clean: Clean, random: Random) -> Mistake:
    one, other = random.choice(clean.robot.joint_names, 2, replace=False)

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        names = [f"joint.{name}.position" for name in (one, other)]
        new = {name: -recording.columns[name] for name in names}
        return spoiled(clean, recording=changed(recording, new))

    return Mistake(f"{one} and {other} negated", spoil, f"sign {one} {other}")


def signed_order(random: Random) -> np.ndarray:
    """Axes in another order, with other signs."""
    R = np.eye(3)
    while np.allclose(R, np.eye(3)):
        R = np.diag(random.choice([-1.0, 1.0], 3))[random.permutation(3)]
    return R


def gyro_axes(clean: Clean, random: Random) -> Mistake:
    R = signed_order(random)
    return Mistake(
        f"gyro axes {R.astype(int).tolist()}",
        vector("gyro", R),
        "axes|axis|order|sign gyro",
    )


def position_axes(clean: Clean, random: Random) -> Mistake:
    R = signed_order(random)
    return Mistake(
        f"position axes {R.astype(int).tolist()}",
        vector("position", R),
        "axes|axis|order|sign position",
    )


def position_left_handed(clean: Clean, random: Random) -> Mistake:
    axis = str(random.choice(["x", "y"]))
    return Mistake(
        f"position {axis} negated",
        columns(f"position.{axis}", times(-1)),
        "axes|axis|sign position",
    )


def position_in_cm(clean: Clean, random: Random) -> Mistake:
    return Mistake(
        "position in cm", columns("position.", times(100)), "cm|centi* position"
    )


def position_in_feet(clean: Clean, random: Random) -> Mistake:
    return Mistake(
        "position in feet",
        columns("position.", times(1 / 0.3048)),
        "unit|scale|feet|foot position",
    )


def inverse_scalar_first(clean: Clean, random: Random) -> Mistake:
    spoil = quaternion(
        lambda x: np.roll(Rotation.from_quat(x).inv().as_quat(), 1, axis=1)
    )
    return Mistake(
        "quaternion inverse, scalar first", spoil, "scalar invers*|conjugat*"
    )


def one_wheel_in_degrees(clean: Clean, random: Random) -> Mistake:
    wheel = str(random.choice(clean.robot.wheel_names))
    return Mistake(
        f"{wheel} in degrees",
        columns(f"wheel.{wheel}.", times(DEGREES)),
        f"degree|unit|scale|gain|inertia {wheel}",
    )


def one_wheel_negated(clean: Clean, random: Random) -> Mistake:
    wheel = str(random.choice(clean.robot.wheel_names))
    return Mistake(
        f"{wheel} negated", columns(f"wheel.{wheel}.", times(-1)), f"sign {wheel}"
    )


def gyro_held(clean: Clean, random: Random) -> Mistake:
    every = int(random.integers(2, 5))
    return Mistake(
        f"gyro every {every}th row new",
        held("gyro", every),
        "repeat*|stale|held|same gyro",
    )


def joint_stuck(clean: Clean, random: Random) -> Mistake:
    joint, start = joint_of(clean, random), middle(clean, random)
    end = start + between(random, 1.0, 3.0)
    return Mistake(
        f"{joint} stuck from {start:g} to {end:g} s",
        held(f"joint.{joint}.", 10**6, start, end),
        f"stuck|repeat*|held|same {joint}",
    )


def position_freezes(clean: Clean, random: Random) -> Mistake:
    start = middle(clean, random)
    return Mistake(
        f"position frozen from {start:g} s on",
        held("position", 10**6, start),
        "stuck|repeat*|held|same|frozen position",
    )


def rows_closed_up(clean: Clean, random: Random) -> Mistake:
    start, lost = middle(clean, random), between(random, 0.3, 2.0)
    return Mistake(
        f"{lost:g} s of rows lost at {start:g} s, times closed up",
        rows_lost(start, start + lost),
        "time|clock|row gap|lost|missing",
    )


def clock_rate(clean: Clean, random: Random) -> Mistake:
    part = either(random) * between(random, 2e-3, 2e-2)
    return Mistake(
        f"time {100 * part:g} % fast",
        stamped(times(1 + part)),
        "time|clock rate|fast|slow|scale",
    )


def spikes(clean: Clean, random: Random) -> Mistake:
    joint, part = joint_of(clean, random), between(random, 0.005, 0.05)
    return Mistake(
        f"{100 * part:g} % of {joint} off by 20 mrad",
        outliers(f"joint.{joint}.position", part, 0.02),
        f"outlier|spike joint|{joint}",
    )


def clipped(start: str, part: float) -> Spoil:
    """A sensor whose range ends at this part of what it should show, by column."""
    return columns(
        start,
        lambda x: np.clip(x, -part * np.nanmax(abs(x)), part * np.nanmax(abs(x))),
    )


def gyro_saturates(clean: Clean, random: Random) -> Mistake:
    part = float(random.uniform(0.6, 0.85))
    return Mistake(
        f"gyro saturates at {100 * part:.0f} %",
        clipped("gyro.", part),
        "saturat*|clip*|stuck|range|same gyro",
    )


KINDS = (
    Kind(two_joints_exchanged),
    Kind(one_joint_in_degrees),
    Kind(one_joint_negated),
    Kind(two_joints_negated),
    Kind(gyro_axes, table=False),
    Kind(position_axes, table=False),
    Kind(position_left_handed, space=False),
    Kind(position_in_cm),
    Kind(position_in_feet, table=False),
    Kind(inverse_scalar_first),
    Kind(one_wheel_in_degrees, table=False, wheels=2),
    Kind(one_wheel_negated, table=False, wheels=2),
    Kind(gyro_held, table=False),
    Kind(joint_stuck),
    Kind(position_freezes),
    Kind(rows_closed_up),
    Kind(clock_rate),
    Kind(spikes),
    Kind(gyro_saturates, table=False),
)
