"""`orbident check ROBOT`."""

from collections.abc import Iterable, Iterator
from math import isfinite
from typing import Annotated, Any

import numpy as np
import typer
from rich.tree import Tree

from orbident.cli.options import Json, Quiet, RobotName
from orbident.robot.description import Coupling, Joint, Robot, Wheel
from orbident.robot.formats.urdf_text import roll_pitch_yaw
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    inertia_about_com,
)


def check(
    robot: RobotName,
    view: Annotated[
        bool,
        typer.Option("--view", help="Then show it in the browser, as 'view' does."),
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Show a robot's tree, masses and sensors, and what looks wrong."""
    from orbident.cli.output import Output
    from orbident.cli.view import view as show
    from orbident.robot.oddities import oddities
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    described = load_robot(robot)
    odd = (*oddities(described), *_irregular(described))
    sensors = list(sensor_lines(described))
    output.say(repr(described), robot_tree(described))
    if sensors:
        output.say("sensors (SI)", *(f"  {line}" for line in sensors))
    output.say(
        *(["odd", *(f"  {each}" for each in odd)] if odd else ["nothing is odd"])
    )
    output.write_json(_document(described, odd))
    if view:
        show(robot, quiet=quiet)


def _irregular(robot: Any) -> tuple[str, ...]:
    """Why other verbs refuse the robot."""
    from orbident.errors import InputError
    from orbident.model.regularity import check_regular

    try:
        check_regular(robot)
    except InputError as error:
        return (str(error),)
    return ()


def _finite(limit: float) -> float | None:
    return limit if isfinite(limit) else None


def _document(robot: Any, odd: tuple[str, ...]) -> dict[str, Any]:
    """Frames as the model has them: the base's at S, any other body's at its joint."""
    bodies = [{"name": robot.bodies[0], "theta": robot.theta[0].tolist()}]
    for joint, name, theta in zip(
        robot.joints, robot.bodies[1:], robot.theta[1:], strict=True
    ):
        bodies.append(
            {
                "name": name,
                "parent": robot.bodies[joint.parent],
                "joint": joint.name,
                "type": joint.kind,
                "axis": joint.axis.tolist(),
                "rotation": joint.R_PJ.tolist(),
                "place": joint.p_PJ.tolist(),
                "position": joint.position and list(map(_finite, joint.position)),
                "velocity": joint.velocity,
                "theta": theta.tolist(),
            }
        )
    return {
        "name": robot.name,
        "motion": robot.motion,
        "mass": robot.mass,
        "bodies": bodies,
        "couplings": [coupling._asdict() for coupling in robot.couplings],
        "wheels": list(robot.wheel_names),
        "sensors": [name for name in robot.sensors if name != "rate"],
        "odd": list(odd),
    }


ROUNDING = 1e-12
"""m and rad: what is below is rounding, and shown as zero."""


def robot_tree(robot: Robot) -> Tree:
    """Bodies below the joints that they hang on.

    A joint's place and turn are in its parent's frame, its axis and the CM of the body
    in the body's; `I` are principal moments about the CM.
    """
    tree = Tree(
        f"{robot.bodies[0]}  {_body_words(robot, 0)}\n"
        f"its frame is at S, {_vector(robot.feature_point)} m in that of its link",
        highlight=False,
    )
    nodes = [tree]
    follows = {each.follower: _coupling_words(each) for each in robot.couplings}
    for k, joint in enumerate(robot.joints, start=1):
        how = _joint_words(joint) + follows.get(joint.name, "")
        words = f"{joint.name}  {how}\n{robot.bodies[k]}  "
        nodes.append(nodes[joint.parent].add(words + _body_words(robot, k)))
    for wheel in robot.wheels:
        tree.add(f"{wheel.name}  wheel, {wheel_words(wheel)}")
    for thruster in robot.thrusters:
        tree.add(
            f"{thruster.name}  thruster at {_vector(thruster.position)} m, towards "
            f"{_vector(thruster.direction)}"
        )
    return tree


def wheel_words(wheel: Wheel) -> str:
    """Its inertia, its axis and its mode."""
    return f"{wheel.inertia:.4g} kg m^2 about {_vector(wheel.axis)}, {wheel.mode}"


def sensor_lines(robot: Robot) -> Iterator[str]:
    """A line for each sensor that the robot file declares, in SI."""
    rate = robot.sensors.get("rate")
    for name, section in robot.sensors.items():
        if not isinstance(section, dict):
            continue
        entries = {"rate": rate} | section
        said = (f"{key} {_value(x)}" for key, x in entries.items() if _tells(x))
        yield f"{name}: {', '.join(said)}"


def _tells(value: Any) -> bool:
    """Zero is what the file leaves out."""
    return value is not None and bool(np.any(np.asarray(value)))


def _value(value: Any) -> str:
    return _vector(value) if isinstance(value, list | tuple) else f"{value:.4g}"


def _body_words(robot: Robot, body: int) -> str:
    theta = robot.theta[body]
    m = theta[MASS]
    if m <= 0:
        return "no mass"
    com = _vector(theta[FIRST_MOMENT] / m)
    moments = _vector(np.linalg.eigvalsh(inertia_about_com(theta)))
    return f"{m:.6g} kg, CM {com} m, I {moments} kg m^2"


def _joint_words(joint: Joint) -> str:
    unit, way = ("rad", "about") if joint.kind == "revolute" else ("m", "along")
    words = [f"{joint.kind} {way} {_vector(joint.axis)}, at {_vector(joint.p_PJ)} m"]
    turned = np.degrees(roll_pitch_yaw(joint.R_PJ))
    if np.abs(turned).max() > ROUNDING:
        words.append(f"turned {_vector(turned)} deg")
    if joint.position is not None:
        words.append(f"in {_vector(joint.position)} {unit}")
    if joint.velocity is not None:
        words.append(f"{joint.velocity:.4g} {unit}/s")
    return ", ".join(words)


def _coupling_words(coupling: Coupling) -> str:
    offset = f" {coupling.offset:+.4g}" if coupling.offset else ""
    return f", follows {coupling.factor:.4g} {coupling.leader}{offset}"


def _vector(values: Iterable[float]) -> str:
    rounded = (0.0 if abs(x) < ROUNDING else float(x) for x in values)
    return "[" + ", ".join(f"{x:.4g}" for x in rounded) + "]"
