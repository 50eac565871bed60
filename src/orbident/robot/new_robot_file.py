"""A robot file to begin with: it loads as it is, and says what to edit."""

import json
import math
import re
from pathlib import Path
from typing import Any

from orbident.robot.description import Joint, Robot
from orbident.robot.parameters import inertia_matrix

_TEMPLATE = Path(__file__).with_name("new_robot.txt")

_WHEEL_NAME = re.compile(r"wheel|(^|[_.-])rw(?![a-z])", re.IGNORECASE)


def new_robot_text(name: str, joints: int, wheels: int, *, table: bool = False) -> str:
    """A commented robot file of an arm of equal links, whose axes alternate.

    The first three wheels are along x, y and z, more are skew. A DH table may stand
    instead of bodies.
    """
    limit = "  joint{}: {{position: [-2.0, 2.0], velocity: 0.35}}"
    return _filled(
        name=json.dumps(name),
        table=table,
        joints=joints,
        wheels=[_wheel(k) for k in range(1, wheels + 1)],
        limits=[limit.format(k) for k in range(1, joints + 1)],
    )


def robot_text_of_model(robot: Robot, model: str) -> tuple[str, tuple[str, ...]]:
    """A commented robot file for a robot that a model file describes.

    The model's file is named from where the robot file is. Joints that are taken for
    wheels because of their names come with the text.
    """
    first = {joint.parent for joint in robot.joints}
    wheels, joints, lines = list[str](), list[Joint](), list[str]()
    for body, joint in enumerate(robot.joints, start=1):
        leaf = joint.parent == 0 and body not in first and joint.kind == "revolute"
        if not (leaf and _WHEEL_NAME.search(f"{joint.name} {robot.bodies[body]}")):
            joints.append(joint)
            continue
        wheels.append(joint.name)
        inertia = joint.axis @ inertia_matrix(robot.theta[body]) @ joint.axis
        own = "" if inertia > 0 else ", inertia: 0.01"
        why = "" if inertia > 0 else "   # the model has none: give yours, kg m^2"
        lines.append(f"{{joint: {json.dumps(joint.name)}{own}}}{why}")
    text = _filled(
        name=json.dumps(robot.name),
        model=json.dumps(model),
        base=robot.bodies[0],
        mass=f"{robot.theta[0, 0]:.4g}",
        wheels=lines,
        limits=[_limit_of(joint) for joint in joints],
    )
    return text, tuple(wheels)


def _filled(limits: list[str], **values: Any) -> str:
    """The template with these values."""
    from jinja2 import Template

    text = _TEMPLATE.read_text("utf-8")
    template = Template(
        text, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    some_limited = any(not line.startswith("#") for line in limits)
    return template.render(values, limits=limits, some_limited=some_limited)


def _limit_of(joint: Joint) -> str:
    """As the model has them; a comment where it does not say all."""
    low, high = joint.position or (-math.inf, math.inf)
    bounded = math.isfinite(low) and math.isfinite(high)
    position = f"[{low:.6g}, {high:.6g}]" if bounded else "[-2.0, 2.0]"
    velocity = "0.35" if joint.velocity is None else f"{joint.velocity:.6g}"
    line = f"{json.dumps(joint.name)}: {{position: {position}, velocity: {velocity}}}"
    if bounded and joint.velocity is not None:
        return f"  {line}"
    return f"#  {line}   # the model does not say all of it"


def _wheel(k: int) -> str:
    axes = {1: (1, 0, 0), 2: (0, 1, 0), 3: (0, 0, 1)}
    turn = math.radians(90 * k - 45)
    axis = axes.get(k, (round(math.cos(turn)), round(math.sin(turn)), 1))
    return f"{{name: rw{k}, axis: {list(axis)}, inertia: 0.02}}"
