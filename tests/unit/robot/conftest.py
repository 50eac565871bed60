from collections.abc import Callable
from pathlib import Path

import pytest
from urdf_texts import ARM

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

Loader = Callable[..., Robot]


@pytest.fixture
def load_urdf(tmp_path: Path) -> Loader:
    """Loads a URDF's text from a file."""

    def load(text: str) -> Robot:
        path = tmp_path / "test.urdf"
        path.write_text(text)
        return load_robot(path)

    return load


@pytest.fixture
def load_yaml(tmp_path: Path) -> Loader:
    """Loads a robot file from its lines after schema and urdf."""

    def load(lines: str = "", urdf: str = ARM) -> Robot:
        (tmp_path / "arm.urdf").write_text(urdf)
        path = tmp_path / "servicer.yaml"
        path.write_text(f"schema: orbident/robot/1\nurdf: arm.urdf\n{lines}\n")
        return load_robot(path)

    return load
