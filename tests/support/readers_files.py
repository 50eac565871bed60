"""The files that a page's reader has already: robots, recordings, RUNs, logs."""

from collections.abc import Callable
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import valved_satellite as satellite
import yaml
from bag_writers import START, Sent, joint_state, pose, write_bag
from burns import Body, burn
from log_writers import write_ulog
from made_results import joined
from pages import ROOT, blocks
from random_motions import random_motion

import orbident as oi
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording
from orbident.robot.parameters import from_mass_com_inertia
from orbident.robot.sensor_schema import AttitudeSpec, PositionSpec
from orbident.simulation.sensor import read_attitude, read_position
from orbident.simulation.simulate import simulate

FIRST = ROOT / "docs" / "first-result.md"
LIBRARY = Path(str(files("orbident.robot") / "library"))
MS = 1_000_000

I_COM = np.array([[6.0, 0.5, -0.3], [0.5, 5.0, 0.2], [-0.3, 0.2, 4.0]])
TARGET = from_mass_com_inertia(50.0, np.array([0.4, 0.1, -0.2]), I_COM)
"""What is captured on the page about it."""

SERVICER = """\
<robot name="servicer">
  <link name="base"><inertial><origin xyz="0.01 0 0.1"/><mass value="200"/>
    <inertia ixx="30" ixy="1" ixz="0" iyy="28" iyz="0" izz="32"/></inertial></link>
  <link name="rw_y"><inertial><mass value="3"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.18" iyz="0" izz="0.1"/></inertial></link>
  <link name="upper_arm"><inertial><origin xyz="0.5 0 0"/><mass value="10"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.9" iyz="0" izz="0.9"/></inertial></link>
  <link name="forearm"><inertial><origin xyz="0.4 0 0"/><mass value="8"/>
    <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.5" iyz="0" izz="0.5"/></inertial></link>
  <joint name="rw_y_joint" type="continuous"><parent link="base"/><child link="rw_y"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper_arm"/>
    <origin xyz="0.5 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="0.5" effort="10"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper_arm"/><child link="forearm"/>
    <origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="0.5" effort="10"/></joint>
</robot>
"""


def first_result() -> None:
    """The robot of the page's file, flown and burnt; a table's bag; a drone's log."""
    Path("servicer.urdf").write_text(SERVICER)
    (shown,) = (b.text for b in blocks(FIRST) if b.language == "yaml")
    Path("servicer.yaml").write_text(shown)
    robot = oi.load_robot("servicer.yaml")
    for seed, name in enumerate(("flight", "other_flight", "earlier", "later")):
        flown = simulate(robot, random_motion(robot, seed), noise="sensors", seed=seed)
        write_recording(flown, f"{name}.csv")
    for recording, run in (("earlier", "before"), ("later", "after")):
        result = oi.identify("servicer.yaml", f"{recording}.csv")
        oi.save_result(result, run)
    write_recording(burn(Body(robot.joint_names, mass=robot.mass)), "burn.csv")
    at_rest()
    table_bag()
    other_tools()


def flyer() -> None:
    """What the robot of a bundled file and its flight are called on several pages."""
    bundled("paper-spatial", "servicer")
    robot = oi.load_robot("servicer.yaml")
    write_recording(
        simulate(robot, random_motion(robot), noise="sensors"), "flight.csv"
    )


def bundled(name: str, copy: str) -> None:
    """A bundled robot under a name of the reader's."""
    urdf, file = ((LIBRARY / f"{name}.{kind}").read_text() for kind in ("urdf", "yaml"))
    Path(f"{name}.urdf").write_text(urdf)
    Path(f"{copy}.yaml").write_text(file)


def capture() -> None:
    """A robot, the same with 50 kg on its last link, and a flight of each."""
    bundled("paper-spatial", "servicer")
    before = yaml.safe_load(Path("servicer.yaml").read_text())
    page = ROOT / "docs" / "how-to" / "after-a-capture.md"
    (text,) = (b.text for b in blocks(page) if b.language == "yaml")
    after = {**before, **yaml.safe_load(text)}
    Path("holding.yaml").write_text(yaml.safe_dump(after))
    # As the page says: all that differs.
    assert before["structure"].pop("link3")
    assert before == after
    robot = oi.load_robot("servicer.yaml")
    held = joined(oi.load_robot("holding.yaml"), "link3", TARGET)
    for seed, (name, flown) in enumerate({"before": robot, "after": held}.items()):
        motion = random_motion(robot, seed=seed, duration=60.0)
        write_recording(
            simulate(flown, motion, noise="sensors", seed=seed), f"{name}.parquet"
        )


def three_flights() -> None:
    """Three recordings of a robot on its table, and one after it took something up."""
    bundled("cepheus-like", "robot")
    robot = oi.load_robot("robot.yaml")
    trajectory = random_motion(robot, 1, 20.0, 50.0, "spun up")
    payload = from_mass_com_inertia(0.005, np.array([0.1, 0.0, 0.0]), 1e-5 * np.eye(3))
    flown = {"first": robot, "second": robot, "third": robot}
    for seed, (name, each) in enumerate(
        {**flown, "bad": joined(robot, "link2", payload)}.items()
    ):
        write_recording(
            simulate(each, trajectory, noise="sensors", seed=seed), f"{name}.csv"
        )


def tilted_table() -> None:
    """20 s on a table that is tilted by 45 urad."""
    bundled("cepheus-like", "robot")
    robot = oi.load_robot("robot.yaml")
    motion = random_motion(robot, 1, 20.0, 50.0, "spun up")
    tilted = replace(motion, environment=oi.Environment(tilt=(40e-6, -20e-6)))
    write_recording(simulate(robot, tilted, noise="sensors"), "flight.csv")


def at_rest() -> None:
    """A minute at rest at 100 Hz: 8.3 um of white noise, 20 um that last for 0.5 s."""
    n, rate, random = 6000, 100.0, np.random.default_rng(0)
    std, time = (2e-5, 2e-5, 2e-5), (0.5, 0.5, 0.5)
    lasting = PositionSpec(std=8.3e-6, markov_std=std, correlation_time=time)
    level = np.tile([0, 0, 0, 1.0], (n, 1))
    x = read_attitude(AttitudeSpec(angle=6e-5), level, 1 / rate, random)
    x[:, :2] = 0.0
    columns = {f"attitude.{k}": x[:, i] for i, k in enumerate("xyzw")}
    columns["position.x"] = read_position(lasting, np.ones((n, 3)), 1 / rate, random)[
        :, 0
    ]
    columns |= {f"position.{k}": np.ones(n) for k in "yz"}
    write_recording(Recording(np.arange(n) / rate, columns), "rest.csv")


def table_bag() -> None:
    """20 s on a table: encoders at 100 Hz, motion capture at 50 Hz."""
    sent: list[Sent] = []
    for k in range(2000):
        stamp = START + 10 * MS * k
        q = [0.3 * np.sin(k / 200), 0.2 * np.cos(k / 300), -1.7 * k]
        names = ["shoulder", "elbow", "wheel_motor"]
        received = stamp + 2 * MS
        rates = [0.1, 0.2, -170.0]
        sent.append(joint_state("/joint_states", received, stamp, names, q, rates))
        if k % 2 == 0:
            angle = k / 2000
            x = [0, 0, np.sin(angle / 2), np.cos(angle / 2)]
            p = [1000 + k / 10, 500, 0] if not 600 <= k < 640 else [np.nan] * 3
            at = stamp + 3 * MS
            sent.append(pose("/mocap/cepheus/pose", received + 9 * MS, at, x, p))
            if k in {100, 102}:
                sent.append(sent[-1]._replace(received=received + 90 * MS))
    write_bag("ros1", Path(), sorted(sent, key=lambda each: each.received), "table")


def finished_map() -> None:
    """The map of `table_bag`, as its page has it when nothing is left to decide."""
    page = ROOT / "docs" / "how-to" / "ros-bag.md"
    (text,) = (b.text for b in blocks(page) if b.title == "map.yaml")
    Path("map.yaml").write_text(text)


def other_tools() -> None:
    """A PX4 log, and a folder of NASA's 42, of bodies that do not move."""
    signals = {"time": np.arange(20) * 0.2, "qbn": np.tile([0, 0, 0, 1.0], (20, 1))}
    Path("InOut").mkdir()
    for name, values in {**signals, "wbn": np.zeros((20, 3))}.items():
        np.savetxt(f"InOut/{name}.42", values, "%le")
    t = {"timestamp": np.arange(20) * 1e4}
    place = dict.fromkeys(("x", "y", "z", "vx", "vy", "vz"), np.zeros(20))
    tables = {
        "vehicle_angular_velocity": {**t, "xyz": np.zeros((20, 3))},
        "vehicle_attitude": {**t, "q": np.tile([1.0, 0, 0, 0], (20, 1))},
        "vehicle_local_position": {**t, **place},
    }
    write_ulog(Path("log.ulg"), tables)


def repository() -> None:
    """What a clone has."""
    Path("benchmarks").symlink_to(ROOT / "benchmarks")


def valves() -> None:
    """A satellite with the four valves of the page, of which the second is dead."""
    truth = satellite.with_dead(satellite.Truth(clock=0.1, pulse=0.03), 2)
    seen = satellite.flown(truth, 4, valves=(0, 1, 4, 5))
    write_recording(seen, Path("flight.csv"))
    again = satellite.flown(truth, 5, valves=(0, 1, 4, 5))
    write_recording(again, Path("other_flight.csv"))
    for k, force in enumerate((45.0, 43.8), start=1):
        on = np.arange(2000) // 200 % 2
        rows = np.column_stack([np.arange(2000) / 50, force * on, on])
        head = "t_s,weight_g,command"
        np.savetxt(f"thruster-{k}.csv", rows, "%g", ",", header=head, comments="")


BEFORE: dict[str, Callable[[], None]] = {
    "docs/faq.md": flyer,
    "docs/first-result.md": first_result,
    "docs/how-to/after-a-capture.md": capture,
    "docs/how-to/designing-an-excitation.md": flyer,
    "docs/how-to/files-of-other-tools.md": other_tools,
    "docs/how-to/flight-computer.md": flyer,
    "docs/how-to/laboratory-checklist.md": first_result,
    "docs/how-to/matlab.md": flyer,
    "docs/how-to/noise-of-sensors.md": at_rest,
    "docs/how-to/ros-bag.md": table_bag,
    "docs/how-to/sample-by-sample.md": flyer,
    "docs/how-to/several-recordings.md": three_flights,
    "docs/how-to/thrusters.md": valves,
    "docs/how-to/what-acts-from-outside.md": tilted_table,
    "docs/how-to/which-sensors.md": flyer,
    "docs/json-files.md": flyer,
    "docs/open-benchmark.md": repository,
    "docs/skill/SKILL.md": first_result,
}
"""What makes these files, by page."""
