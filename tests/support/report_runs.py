"""Identifications to be reported on, each made once in a process."""

from dataclasses import replace
from functools import cache

from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

HOSTILE = {
    "name": "<script>document.title='taken'</script>" + "long " * 52,
    "joint1": "<img src=x onerror=\"document.title='taken'\">",
    "joint2": "'\"><b>bold</b> %{y} &amp; $x$",
    "joint3": "_".join(["very"] * 60),
    "link1": "</script><script>document.title='taken'</script>",
}
"""What the robot's own name, its joints and a link are called."""


@cache
def flown() -> tuple[Robot, Recording]:
    """`paper-spatial` and 20 s of it, with the noise of its sensors."""
    robot = load_robot("paper-spatial")
    motion = random_motion(robot, duration=20.0)
    return robot, simulate(robot, motion, noise="sensors", seed=1)


@cache
def result() -> Result:
    """The result of least squares for the flown recording."""
    return identify(*flown(), "least-squares")


@cache
def rejected() -> Result:
    """Without a velocity."""
    robot, recording = flown()
    kept = {
        name: column
        for name, column in recording.columns.items()
        if not name.startswith(("position", "velocity", "accelerometer"))
    }
    return identify(robot, Recording(recording.t, kept), "least-squares")


def hostile() -> Result:
    """The same numbers, of a robot whose names are markup."""
    found = result()
    robot = found.robot
    joints = tuple(replace(joint, name=HOSTILE[joint.name]) for joint in robot.joints)
    bodies = tuple(HOSTILE.get(body, body) for body in robot.bodies)
    structure = {HOSTILE.get(name, name): s for name, s in robot.structure.items()}
    renamed = replace(
        robot, name=HOSTILE["name"], joints=joints, bodies=bodies, structure=structure
    )
    assert found.motion is not None
    moved = {HOSTILE[k]: x for k, x in found.motion["joints"].items()}
    motion = {**found.motion, "joints": moved}
    signals = tuple(
        signal._replace(axes=tuple(HOSTILE[f"joint{k + 1}"] for k in range(3)))
        for signal in found.signals()
    )
    return replace(
        found,
        robot=renamed,
        motion=motion,
        notes=(f"joint '{HOSTILE['joint1']}' never moved",),
        rejected={HOSTILE["joint2"]: {HOSTILE["link1"]: 3}},
        input={"file": HOSTILE["joint1"], "sha256": "0" * 64},
        signals=lambda: signals,
    )
