"""Kinds of mistakes in sensors: clocks, mountings, scales, zeros, jumps, noise."""

import math
from collections.abc import Callable

import numpy as np
from drawn import Kind, Random, about, between, direction, either, joint_of, middle
from mistake import Mistake
from recordings import Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import Change, columns, drift, plus, quaternion, times, vector
from wrong_sensors import clock, marker, sensed

from orbident.model.kinematics import poses


def _clock(sensor: str) -> Callable[[Clean, Random], Mistake]:
    def draw(clean: Clean, random: Random) -> Mistake:
        early = between(random, 0.02, 0.4)
        return Mistake(
            f"{sensor} {early:g} s early",
            clock(sensor, -early),
            f"clock|early|late|delay* {sensor}",
        )

    draw.__name__ = f"{sensor}_early"
    return draw


def turned_by(angle: float, axis: np.ndarray) -> Rotation:
    """Degrees."""
    return Rotation.from_rotvec(math.radians(angle) * axis)


def attitude_turned(clean: Clean, random: Random) -> Mistake:
    angle = between(random, 1.0, 10.0)
    R = turned_by(angle, about(clean, random))
    return Mistake(
        f"attitude sensor turned {angle:g} deg",
        quaternion(lambda x: (Rotation.from_quat(x) * R).as_quat()),
        "misalign*|turned|rotat* attitude",
    )


def other_inertial_axes(clean: Clean, random: Random) -> Mistake:
    angle = between(random, 2.0, 20.0)
    R = turned_by(angle, about(clean, random))
    return Mistake(
        f"attitude in other inertial axes, {angle:g} deg",
        quaternion(lambda x: (R * Rotation.from_quat(x)).as_quat()),
        "axes|axis|frame attitude position",
    )


def gyro_turned(clean: Clean, random: Random) -> Mistake:
    angle = between(random, 0.5, 5.0)
    R = turned_by(angle, about(clean, random)).as_matrix()
    return Mistake(
        f"gyro turned {angle:g} deg", vector("gyro", R), "misalign*|turned|rotat* gyro"
    )


def joint_zero(clean: Clean, random: Random) -> Mistake:
    joint, off = joint_of(clean, random), either(random) * between(random, 0.01, 0.04)
    return Mistake(
        f"{joint} zero off {1000 * off:g} mrad",
        columns(f"joint.{joint}.", plus(off)),
        f"zero|offset {joint}",
    )


def joint_scale(clean: Clean, random: Random) -> Mistake:
    joint, off = joint_of(clean, random), either(random) * between(random, 0.01, 0.03)
    return Mistake(
        f"{joint} scale {100 * off:g} %",
        columns(f"joint.{joint}.", times(1 + off)),
        f"scale {joint}",
    )


def gyro_scale(clean: Clean, random: Random) -> Mistake:
    off = either(random) * between(random, 3e-3, 2e-2)
    return Mistake(
        f"gyro scale {100 * off:g} %", columns("gyro.", times(1 + off)), "scale gyro"
    )


def position_scale(clean: Clean, random: Random) -> Mistake:
    off = either(random) * between(random, 5e-3, 5e-2)
    return Mistake(
        f"position scale {100 * off:g} %",
        columns("position.", times(1 + off)),
        "scale position",
    )


def marker_off(clean: Clean, random: Random) -> Mistake:
    off = between(random, 5e-3, 5e-2)
    return Mistake(
        f"position {1000 * off:g} mm from S",
        marker(off * direction(clean, random)),
        "marker|offset|point",
    )


def marker_on_a_link(clean: Clean, random: Random) -> Mistake:
    """0.1 m beside the first joint."""
    out = 0.1 * direction(clean, random)

    def spoil(clean: Clean) -> Spoiled:
        true = clean.true
        at = poses(clean.robot, true.q)
        off = at.d[:, 1] + at.R[:, 1] @ out
        R_WB = Rotation.from_quat(true.attitude)
        seen = true._replace(position=true.position + R_WB.apply(off))
        return spoiled(clean, recording=clean.recorded(seen))

    return Mistake("marker on the first link", spoil, "marker|point|body|link")


def from_then_on(start: float, change: Change) -> Callable[[Clean], Change]:
    """A change that begins at a time, s."""

    def of(clean: Clean) -> Change:
        later = clean.t >= start
        return lambda x: np.where(later, change(x), x)

    return of


def jumping(column: str, start: float, size: float) -> Spoil:
    """An offset from a time on."""
    change = from_then_on(start, plus(size))
    return lambda clean: columns(column, change(clean))(clean)


def attitude_jump(clean: Clean, random: Random) -> Mistake:
    angle, start = between(random, 0.3, 1.5), middle(clean, random)
    R, later = turned_by(angle, about(clean, random)), clean.t >= start

    def change(x: np.ndarray) -> np.ndarray:
        moved = (Rotation.from_quat(x) * R).as_quat()
        return np.where(later[:, None], moved, x)

    return Mistake(
        f"attitude jumps {angle:g} deg at {start:g} s",
        quaternion(change),
        "jump*|step attitude",
    )


def attitude_drift(clean: Clean, random: Random) -> Mistake:
    rate = between(random, 0.01, 0.1)
    axis = about(clean, random)

    def change(x: np.ndarray) -> np.ndarray:
        turns = Rotation.from_rotvec(np.outer(math.radians(rate) * clean.t, axis))
        return (Rotation.from_quat(x) * turns).as_quat()

    return Mistake(
        f"attitude drifts {rate:g} deg/s", quaternion(change), "drift* attitude"
    )


def position_jump(clean: Clean, random: Random) -> Mistake:
    size, start = between(random, 5e-3, 3e-2), middle(clean, random)
    return Mistake(
        f"position jumps {1000 * size:g} mm at {start:g} s",
        jumping("position.y", start, size),
        "jump*|step position",
    )


def joint_slip(clean: Clean, random: Random) -> Mistake:
    joint, size = joint_of(clean, random), between(random, 0.01, 0.04)
    start = middle(clean, random)
    return Mistake(
        f"{joint} slips {1000 * size:g} mrad at {start:g} s",
        jumping(f"joint.{joint}.", start, size),
        f"jump*|slip*|step {joint}",
    )


def gyro_drift(clean: Clean, random: Random) -> Mistake:
    axis, rate = str(random.choice(list("xyz"))), between(random, 1e-5, 5e-5)
    return Mistake(
        f"gyro {axis} drifts {1000 * rate:g} mrad/s^2",
        drift(f"gyro.{axis}", rate),
        "drift* gyro",
    )


def gyro_jump(clean: Clean, random: Random) -> Mistake:
    axis, size = str(random.choice(list("xyz"))), between(random, 5e-4, 2e-3)
    start = middle(clean, random)
    return Mistake(
        f"gyro {axis} jumps {1000 * size:g} mrad/s at {start:g} s",
        jumping(f"gyro.{axis}", start, size),
        "jump*|step gyro",
    )


def noisy_encoders(clean: Clean, random: Random) -> Mistake:
    n = between(random, 5.0, 15.0)
    declared = clean.robot.sensors.of("joints").white_std()
    return Mistake(
        f"encoder noise {n:g} times",
        sensed("joints", position=n * declared),
        "noise joint|encoder",
    )


def noisy_attitude(clean: Clean, random: Random) -> Mistake:
    n = between(random, 5.0, 15.0)
    declared = clean.robot.sensors.of("attitude").white_std()
    return Mistake(
        f"attitude noise {n:g} times",
        sensed("attitude", angle=n * declared),
        "noise attitude",
    )


KINDS = (
    Kind(_clock("position")),
    Kind(_clock("attitude")),
    Kind(_clock("joint")),
    Kind(_clock("gyro"), table=False),
    Kind(attitude_turned),
    Kind(other_inertial_axes),
    Kind(gyro_turned, table=False),
    Kind(joint_zero),
    Kind(joint_scale),
    Kind(gyro_scale, table=False),
    Kind(position_scale, table=False),
    Kind(marker_off),
    Kind(marker_on_a_link),
    Kind(attitude_jump),
    Kind(attitude_drift, table=False),
    Kind(position_jump),
    Kind(joint_slip),
    Kind(gyro_drift, table=False),
    Kind(gyro_jump, table=False),
    Kind(noisy_encoders),
    Kind(noisy_attitude),
)
