"""A campaign whose runs take the least time: ten seconds of the paper's servicer."""

from importlib.resources import files
from pathlib import Path
from typing import Any

import pyarrow as pa
import yaml
from random_motions import random_motion

from orbident.campaigns.folder import Campaign, begin, read_rows
from orbident.campaigns.spec import load_spec
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory_file import save_trajectory

TOLERANCES = {
    "joints": {"zero": 0.001, "scale": 0.001, "place": 0.001, "direction": 0.001},
    "feature_point": 0.001,
    "wheels": {"inertia": 0.01},
    "gyro": {"misalignment": 0.001, "scale": 0.001},
    "clocks": {"joints": 0.01},
}


def write_campaign(folder: Path, **changes: Any) -> Path:
    """The campaign's file beside its robot and its trajectory.

    Args:
        folder: made if it is missing.
        changes: keys of the campaign file.
    """
    folder.mkdir(exist_ok=True)
    robot = load_robot("paper-spatial")
    library = Path(str(files("orbident.robot"))) / "library"
    document = yaml.safe_load((library / "paper-spatial.yaml").read_text())
    document["sensors"]["rate"] = 5.0
    document["tolerances"] = TOLERANCES
    (folder / "robot.yaml").write_text(yaml.safe_dump(document))
    urdf = (library / document["urdf"]).read_bytes()
    (folder / document["urdf"]).write_bytes(urdf)
    save_trajectory(random_motion(robot, duration=10.0), folder / "motion.yaml")
    spec = {
        "schema": "orbident/campaign/1",
        "robots": [{"robot": "robot.yaml", "trajectory": "motion.yaml"}],
        "methods": ["least-squares"],
        "runs": 3,
        "entropy": 1,
        "chunk": 1,
        "disperse": {"inertia": {"normal": "10 %"}},
    }
    path = folder / "campaign.yaml"
    path.write_text(yaml.safe_dump(spec | changes))
    return path


def begun(folder: Path, name: str = "out", **changes: Any) -> tuple[Campaign, Path]:
    """A campaign and its folder, nothing made yet."""
    path = write_campaign(folder, **changes)
    out = folder / name
    return begin(load_spec(path), out, no_paper_motion), out


def no_paper_motion(_: Any) -> Any:
    raise AssertionError("the campaign has a trajectory of its own")


def rows(campaign: Campaign, folder: Path) -> pa.Table:
    return read_rows(campaign, folder)
