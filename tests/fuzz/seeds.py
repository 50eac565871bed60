"""Valid files that cases are made from, written by the commands themselves."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from bag_writers import START, Sent, float64, imu, joint_state, pose, write_bag
from case import STDIN, Case
from live_streams import csv_lines, flown
from log_writers import KINDS as LOGS
from log_writers import write_log
from robot_parts import mjcf_of, random_parts, sdf_of
from small_campaigns import write_campaign
from watcher import Watcher

from orbident.robot.new_robot_file import new_robot_text


@dataclass(frozen=True)
class Robot:
    """A bundled robot, and how it is moved."""

    name: str
    joints: tuple[str, ...]
    wheels: tuple[str, ...]
    rate: float
    """Samples per second that keep a recording short, Hz."""
    wheel_speed: float
    """Speed of every wheel at the start, rad/s."""


ROBOTS = (
    Robot(
        "paper-spatial", ("joint1", "joint2", "joint3"), ("rw_x", "rw_y", "rw_z"), 5, 80
    ),
    Robot("cepheus-like", ("joint1", "joint2"), ("rw",), 10, 100),
    Robot(
        "dual-arm",
        tuple(f"{arm}_joint{k}" for arm in ("left", "right") for k in range(1, 8)),
        ("rw_x", "rw_y", "rw_z"),
        5,
        50,
    ),
)
"""The bundled ones."""

PATIENCE = 600.0
"""Seconds, on a busy machine: how long it takes to make a seed is no finding."""

DURATION = 12.0
"""s: the shortest recordings from which all methods identify `paper-spatial`."""

STREAMED, LIVE_RATE = 8.0, 10.0
"""s and Hz: more samples than the filter begins with."""
LIVE = ("live", "paper-spatial", "--velocity-std", "1e-3", "--state", "state")

MAP = """\
schema: orbident/topic-map/1
topics:
  - topic: /joint_states
    type: sensor_msgs/JointState
    take: {position: rad, velocity: rad/s}
    joints: {shoulder: joint1, elbow: joint2}
  - topic: /wheel
    type: std_msgs/Float64
    take: {wheel.rw.speed: rad/s}
  - topic: /imu
    type: sensor_msgs/Imu
    take: {gyro: rad/s}
    frame: base
    clock: imu
  - topic: /mocap
    type: geometry_msgs/PoseStamped
    take: {position: m, attitude: quaternion}
    pose: base-in-inertial
    frame: base
    point: S
"""

LOG_MAP = """\
schema: orbident/topic-map/1
topics:
  - topic: /log
    type: table
    stamp: {timestamp: us}
    take: {joint.joint1.position: deg, gyro: rad/s}
    fields: {joint.joint1.position: -q, gyro: [w.0, w.1, 0]}
    frame: base
"""

XACRO = """\
<robot name="sc" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="mass" default="7"/>
  <xacro:property name="side" value="0.5"/>
  <xacro:macro name="part" params="name">
    <link name="${name}">
      <inertial>
        <mass value="$(arg mass)"/>
        <inertia ixx="${2 * side}" iyy="1" izz="1.5" ixy="0" ixz="0" iyz="0"/>
      </inertial>
    </link>
  </xacro:macro>
  <xacro:part name="base"/>
  <xacro:part name="arm"/>
  <joint name="j" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <origin xyz="${side / 2} 0 0"/>
    <axis xyz="0 0 1"/>
  </joint>
</robot>
"""

BAGS = ("ros1", "ros2-sqlite3", "ros2-mcap", "mcap-ros2")
MESSAGES = 20
PERIOD = 50_000_000
"""Time from one message to the next, ns."""


@dataclass(frozen=True)
class Seeds:
    """The valid files, by what they are."""

    robots: dict[str, dict[str, bytes]]
    """Robot file and URDF of every bundled robot, by its name."""
    trajectories: dict[str, bytes]
    csv: dict[str, bytes]
    parquet: dict[str, bytes]
    run: dict[str, bytes]
    """Files of the folder that an identification of `paper-spatial` writes."""
    bags: dict[str, dict[str, bytes]]
    logs: dict[str, tuple[str, bytes]]
    """Files of other tools: suffix and content."""
    models: dict[str, bytes]
    """Robots in every other format than URDF."""
    stream: bytes
    """Lines that `live` reads from standard input, of `paper-spatial`."""
    state: bytes
    """What `live --state` writes after them."""
    campaign: dict[str, bytes]
    """The campaign file `campaign.yaml`, what it names, and its folder `out`."""


def made(watcher: Watcher, folder: Path) -> Seeds:
    """All seeds.

    Args:
        watcher: that runs the commands.
        folder: an empty one, for bags.
    """
    names = [robot.name for robot in ROBOTS]
    trajectories = {robot.name: _trajectory(robot).encode() for robot in ROBOTS}
    simulated = {robot.name: _simulated(watcher, robot) for robot in ROBOTS}
    recording = simulated["paper-spatial"]["r.csv"]
    stream = b"\n".join(csv_lines(flown(STREAMED, LIVE_RATE))) + b"\n"
    return Seeds(
        robots={name: dict(_robot_files(name)) for name in names},
        trajectories=trajectories,
        csv={name: simulated[name]["r.csv"] for name in names},
        parquet={name: simulated[name]["r.parquet"] for name in names},
        run=_identified(watcher, recording),
        bags={kind: _bag(kind, folder / kind) for kind in BAGS},
        logs={kind: _log(kind, folder / f"log-{kind}") for kind in LOGS},
        models=_models(),
        stream=stream,
        state=_written(watcher, LIVE, {STDIN: stream})["state"],
        campaign=_campaign(watcher, folder / "campaign"),
    )


def _models() -> dict[str, bytes]:
    parts = random_parts(0, count=5)
    return {
        "robot.xml": mjcf_of(parts).replace("><", ">\n<").encode(),
        "robot.sdf": sdf_of(parts).replace("><", ">\n<").encode(),
        "robot.xacro": XACRO.encode(),
        "bodies.yaml": new_robot_text("bodies", 2, 1).encode(),
        "dh.yaml": new_robot_text("dh", 2, 1, table=True).encode(),
    }


def _robot_files(name: str) -> Iterator[tuple[str, bytes]]:
    folder = files("orbident.robot") / "library"
    for suffix in ("yaml", "urdf"):
        yield f"{name}.{suffix}", (folder / f"{name}.{suffix}").read_bytes()


def _trajectory(robot: Robot) -> str:
    joints = "".join(
        f"  {name}: {{a: [{0.2 + 0.01 * k}, -0.1, 0.05], b: [0.1, {0.1 + 0.01 * k}, "
        f"-0.08], start: {{position: 0.3}}, end: {{position: 0.3}}}}\n"
        for k, name in enumerate(robot.joints)
    )
    speeds = ", ".join(f"{name}: {robot.wheel_speed}" for name in robot.wheels)
    rate = "[0, 0, -0.2]" if len(robot.wheels) == 1 else "[0.01, 0.03, 0.02]"
    return (
        f"schema: orbident/trajectory/1\nduration: {DURATION}\njoints:\n{joints}"
        f"initial:\n  angular_velocity: {rate}\n  wheel_speed: {{{speeds}}}\n"
    )


def _simulated(watcher: Watcher, robot: Robot) -> dict[str, bytes]:
    trajectory = {"m.yaml": _trajectory(robot).encode()}
    start = ("simulate", robot.name, "m.yaml", "--rate", str(robot.rate), "--noise")
    return {
        name: _written(watcher, (*start, noise, "-o", name), trajectory)[name]
        for name, noise in (("r.csv", "sensors"), ("r.parquet", "sensors"))
    }


def _identified(watcher: Watcher, recording: bytes) -> dict[str, bytes]:
    arguments = ("identify", "paper-spatial", "r.csv", "-o", "run")
    method = ("--method", "structured")
    return _written(watcher, (*arguments, *method), {"r.csv": recording})


def _campaign(watcher: Watcher, folder: Path) -> dict[str, bytes]:
    write_campaign(folder)
    given = {path.name: path.read_bytes() for path in folder.iterdir()}
    arguments = ("campaign", "run", "campaign.yaml", "-o", "out", "--workers", "1")
    made = _written(watcher, arguments, given)
    return given | {n: c for n, c in made.items() if not n.endswith("report.html")}


def _written(
    watcher: Watcher, arguments: tuple[str, ...], given: dict[str, bytes]
) -> dict[str, bytes]:
    outcome = watcher.run(Case("seeds", arguments, given), longest=PATIENCE)
    if outcome.status == 2 or not outcome.left:
        raise RuntimeError(f"{' '.join(arguments)}: {outcome.err}")
    return dict(outcome.left)


def _bag(kind: str, folder: Path) -> dict[str, bytes]:
    folder.mkdir()
    write_bag(kind, folder, _messages(), name="bag")
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _log(kind: str, folder: Path) -> tuple[str, bytes]:
    folder.mkdir()
    times = PERIOD / 1000 * np.arange(MESSAGES)
    table = {"timestamp": times, "q": times / 1e6, "w": np.ones((MESSAGES, 3))}
    path = write_log(kind, folder, {"log": table, "other": table})
    return path.suffix, path.read_bytes()


def _messages() -> list[Sent]:
    sent = []
    for k in range(MESSAGES):
        ns, x = START + PERIOD * k, 0.01 * k
        names = ("shoulder", "elbow")
        sent += [
            joint_state("/joint_states", ns, ns, names, [x, -x], [0.2, -0.2]),
            float64("/wheel", ns, 100.0 - k),
            imu("/imu", ns, ns, [0, 0, x]),
            pose("/mocap", ns, ns, [0, 0, 0, 1], [x, 0, 0]),
        ]
    return sent
