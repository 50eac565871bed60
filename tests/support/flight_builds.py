"""Flight builds: exported folders, compiled."""

import shutil
import sys
from pathlib import Path

import pytest
from processes import finished
from random_motions import random_motion

from orbident.estimation.recursive.driven_joints import torques_of
from orbident.identified.flight_export import export_flight
from orbident.preprocessing.samples import samples_of
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

CHECKS = Path(__file__).parents[1] / "unit" / "identified" / "flight_checks.c"
SCALARS = {"double": "replay", "float": "replay_float"}
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror")

# A flight build is compiled by the user's own tools, and nm shows what it calls. Where
# they are missing there is nothing to test; the rest of the package does without them.
needs_compilers = pytest.mark.skipif(
    None in map(shutil.which, ("cmake", "cc", "c++", "nm"))
    or not sys.platform.startswith("linux"),
    reason="cmake, cc, c++ or nm is missing, or this is not Linux",
)


def exported(
    folder: Path, name: str | Path, duration: float, rate: float, seed: int = 0
) -> Path:
    """The folder of a robot that turns while its joints move."""
    return exported_of(load_robot(name), folder, duration, rate, seed)


def exported_of(
    robot: Robot, folder: Path, duration: float, rate: float, seed: int = 0
) -> Path:
    """Export the flight filter of a robot that has no file."""
    motion = random_motion(robot, duration=duration, seed=seed)
    recording = simulate(robot, motion, rate=rate, noise="sensors", seed=seed)
    samples = samples_of(robot, recording)
    torques = torques_of(robot, recording, samples, {})
    export_flight(robot, samples, torques, None, folder)
    return folder


ONE_JOINT = """\
<robot name="one-joint">
  <link name="base"><inertial><origin xyz="0.1 0.05 0"/><mass value="80"/>
    <inertia ixx="9" iyy="8" izz="7" ixy="0.2" ixz="0.1" iyz="0.3"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0.3 0 0.1"/><mass value="8"/>
    <inertia ixx="0.3" iyy="0.5" izz="0.6" ixy="0" ixz="0.05" iyz="0"/></inertial>
    </link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0.5 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="9"/></joint>
</robot>
"""


def one_joint(folder: Path, joint: str = "revolute", wheel: bool = True) -> Path:
    """The file of a robot that is small enough for very many steps."""
    urdf = ONE_JOINT.replace("revolute", joint)
    (folder / "one-joint.urdf").write_text(urdf)
    wheels = "[{name: rw, axis: [0, 1, 0], inertia: 0.05, mode: held}]"
    sensors = (
        "{gyro: {angle_random_walk: 1e-5}, attitude: {angle: 1e-5}, "
        "position: {std: 1e-4}, joints: {position: 1e-5}, wheels: {position: 1e-5}, "
        "torques: {std: 0.01}}"
    )
    path = folder / "one-joint.yaml"
    path.write_text(
        "schema: orbident/robot/1\nname: one-joint\nurdf: one-joint.urdf\n"
        f"wheels: {wheels if wheel else []}\nsensors: {sensors}\n"
    )
    return path


def sliding(folder: Path) -> Path:
    """The same with a joint that slides."""
    return one_joint(folder, "prismatic")


def library(folder: Path, scalar: str = "double") -> Path:
    """The filter, as the folder's own CMakeLists.txt builds it; with `replay`.

    It is the same for every robot.
    """
    build = folder / "b"
    ran("cmake", "-S", folder, "-B", build)
    ran("cmake", "--build", build, "--target", SCALARS[scalar])
    return build / f"libflight_{SCALARS[scalar]}.a"


def program(source: Path, folder: Path, filter_: Path, scalar: str = "double") -> Path:
    """A C program with the tables of the folder, and the filter that is built."""
    out = folder / f"{source.stem}_{scalar}"
    paths = [f"-I{folder}", f"-I{folder / 'include'}"]
    flags = ["-std=gnu11", "-O1", *WARNINGS, f"-DORBIDENT_REAL={scalar}", *paths]
    ran("cc", *flags, source, filter_, "-lm", "-o", out)
    return out


def ran(*command: object, limit: float = 300.0) -> str:
    """What a command prints that ends with status 0 and complains of nothing."""
    run = finished(*command, limit=limit)
    assert (run.returncode, run.stderr) == (0, ""), run.stdout + run.stderr
    return run.stdout
