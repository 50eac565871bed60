"""The satellite of `examples/mujoco-panels` with limits of its arm."""

from pathlib import Path

import yaml
from examples import EXAMPLES

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

ARM = ("shoulder", "elbow")


def swinging_satellite(folder: Path) -> Robot:
    """Written into a folder as `satellite.yaml`."""
    example = EXAMPLES / "mujoco-panels"
    document = yaml.safe_load((example / "satellite.yaml").read_text())
    document["model"] = str(example / "satellite.xml")
    document["limits"] = {
        name: {"velocity": 0.5, "position": [-1.5, 1.5]} for name in ARM
    }
    (folder / "satellite.yaml").write_text(yaml.safe_dump(document))
    return load_robot(folder / "satellite.yaml")
