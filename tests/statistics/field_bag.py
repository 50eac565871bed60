"""A recording as a bag of the field: all that may be wrong with one is."""

from pathlib import Path

import numpy as np
from bag_writers import Sent, imu, joint_state, pose, write_bag

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

OFFSET = 0.037
"""s: by so much the stamps of the base's sensors are ahead of the encoders'."""

START = 1_700_000_000_000_000_000
MISSING, TWICE, LATE = 0.03, 0.02, 0.05
BURST = slice(700, 712)

MAP = """
schema: orbident/topic-map/1
topics:
  - topic: /joint_states
    type: sensor_msgs/JointState
    take: {{position: rad}}
    joints: {{{joints}}}
    wheels: {{{wheels}}}
    clock: robot
  - {base}
"""
IMU = """topic: /imu
    type: sensor_msgs/Imu
    take: {gyro: rad/s, accelerometer: m/s^2}
    frame: base
    point: S
    clock: imu"""
MOCAP = """topic: /mocap
    type: geometry_msgs/PoseStamped
    take: {position: m, attitude: quaternion}
    pose: base-in-inertial
    frame: base
    point: S
    clock: mocap"""


def topic_map(robot: Robot, base: str) -> str:
    """The map of such a bag."""

    def same(names):
        return ", ".join(f"{name}: {name}" for name in names)

    return MAP.format(
        joints=same(robot.joint_names), wheels=same(robot.wheel_names), base=base
    )


def field_bag(
    kind: str, folder: Path, robot: Robot, recording: Recording, seed: int
) -> Path:
    """Messages shuffled, late, twice, missing; a burst of NaN; two clocks apart."""
    random = np.random.default_rng(seed)
    names = [f"joint.{name}.position" for name in robot.joint_names]
    names += [f"wheel.{name}.position" for name in robot.wheel_names]
    angles = np.column_stack([recording.column(name) for name in names])
    angles[BURST] = np.nan
    labels = [*robot.joint_names, *robot.wheel_names]
    sent: list[Sent] = []
    for k, t in enumerate(recording.t):
        stamp = START + round(1e9 * t)
        ahead = stamp + round(1e9 * OFFSET)
        joints = joint_state("/joint_states", stamp, stamp, labels, angles[k])
        for message in (joints, _base(recording, k, ahead)):
            if random.random() > MISSING:
                sent += [message] * (2 if random.random() < TWICE else 1)
    delays = random.uniform(0, 0.03, len(sent))
    delays += np.where(random.random(len(sent)) < LATE, random.uniform(0, 2), 0.0)
    received = [m.received + round(1e9 * d) for m, d in zip(sent, delays, strict=True)]
    order = np.argsort(received, kind="stable")
    sent = [sent[k]._replace(received=received[k]) for k in order]
    return write_bag(kind, folder, sent)


def _base(recording: Recording, k: int, stamp: int) -> Sent:
    bad = np.nan if BURST.start <= k < BURST.stop else 1.0
    if recording.has("gyro.x"):
        gyro, force = (recording.vector(s)[k] for s in ("gyro", "accelerometer"))
        return imu("/imu", stamp, stamp, bad * gyro, force)
    x, p = recording.vector("attitude", "xyzw")[k], recording.vector("position")[k]
    return pose("/mocap", stamp, stamp, x, bad * p)
