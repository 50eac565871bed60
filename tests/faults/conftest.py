"""Inputs of all verbs, and what they make of them undisturbed."""

from collections.abc import Callable
from pathlib import Path

import pytest
from bag_writers import START, float64, imu, joint_state, write_bag
from processes import ORBIDENT, finished
from random_motions import random_motion
from verbs import IDENTIFY, OLD, PLACES, VERBS, Shelf

from orbident.recordings.tables import write_recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.trajectories.trajectory_file import save_trajectory

MAP = """\
schema: orbident/topic-map/1
topics:
  - {topic: /joints, type: sensor_msgs/JointState, take: {position: rad},
     joints: {joint1: joint1}}
  - {topic: /wheel, type: std_msgs/Float64, take: {wheel.rw_x.speed: rad/s}}
  - {topic: /imu, type: sensor_msgs/Imu, take: {gyro: rad/s}, frame: base}
"""


@pytest.fixture(scope="session")
def shelf(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Shelf]:
    """Makes what these verbs need, each once."""
    folder = tmp_path_factory.mktemp("shelf")
    made: dict[str, Path] = {}
    _write_inputs(folder)

    def ready(*names: str) -> Shelf:
        for name in ("run", *names):
            if name not in made:
                made[name] = _undisturbed(folder, name)
        return Shelf(folder, dict(made))

    return ready


def _write_inputs(folder: Path) -> None:
    robot = load_robot("paper-spatial")
    motion = random_motion(robot, duration=10.0)
    save_trajectory(motion, folder / "t.yaml")
    write_recording(simulate(robot, motion, rate=5.0), folder / "r.csv")
    sent = []
    for k in range(2000):
        ns = START + k * 10_000_000
        sent.append(joint_state("/joints", ns, ns, ["joint1"], [0.001 * k]))
        sent.append(float64("/wheel", ns, k))
        sent.append(imu("/imu", ns, ns, (0.0, 0.0, 0.1)))
    write_bag("mcap-ros2", folder, sent)
    (folder / "topics.yaml").write_text(MAP)


def _undisturbed(folder: Path, name: str) -> Path:
    """What a verb leaves when nothing happens."""
    arguments = IDENTIFY if name == "run" else VERBS[name]
    ran = finished(*ORBIDENT, *arguments, cwd=folder)
    assert ran.returncode == 0, ran.stderr
    return folder / (OLD if name == "run" else PLACES[name])
