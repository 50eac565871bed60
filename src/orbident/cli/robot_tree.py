"""A robot in words: its tree of bodies, its wheels and its sensors."""

from collections.abc import Iterable, Iterator

import numpy as np
from rich.tree import Tree

from orbident.robot.description import NO_ROTOR, Coupling, Joint, Robot, Wheel
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com
from orbident.robot.urdf import roll_pitch_yaw

ROUNDING = 1e-12
"""m and rad: what is below is rounding, and shown as zero."""

SMALL = 1e-6
"""Products of inertia below this part of the largest moment are not shown."""


def robot_tree(robot: Robot) -> Tree:
    """Bodies below the joints that they hang on.

    A joint's place and turn are in its parent's frame, its axis and the CM of the body
    in the body's; `I` is about the CM, in the body's axes.
    """
    tree = Tree(
        f"{robot.bodies[0]}  {_body_words(robot, 0)}\n"
        f"body frame at S, {_vector(robot.feature_point)} m from the link frame",
        highlight=False,
    )
    nodes = [tree]
    follows = {each.follower: _coupling_words(each) for each in robot.couplings}
    for k, joint in enumerate(robot.joints, start=1):
        how = _joint_words(joint) + follows.get(joint.name, "")
        how += driven_words(robot, joint)
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


def driven_words(robot: Robot, joint: Joint) -> str:
    """What is declared of its motor, its friction or its spring, SI."""
    name, words = joint.name, ""
    rotor = robot.rotors.get(name, NO_ROTOR)
    if rotor.inertia:
        words += (
            f", rotor {rotor.inertia:.4g} kg m^2 +- {100 * rotor.tolerance:.3g} % "
            f"behind {rotor.gear:.4g}"
        )
    if passive := robot.passive.get(name):
        words += (
            f", passive at {passive.frequency:.4g} Hz +- "
            f"{100 * passive.tolerance:.3g} %, damped by {100 * passive.damping:.3g} %"
        )
    if (constant := robot.torque_constants.get(name)) is not None:
        unit = "N m/A" if joint.kind == "revolute" else "N/A"
        std = robot.tolerances.joint_torque_scale[name]
        words += f", torque constant {constant:.4g} {unit} +- {100 * std:.3g} %"
    if friction := robot.friction.get(name):
        words += (
            f", friction {friction.viscous:.4g} viscous, {friction.coulomb:.4g} "
            f"Coulomb, offset {friction.offset:.4g}"
        )
        if friction.tolerance is not None:
            words += f" +- {100 * friction.tolerance:.3g} %"
    return words


def wheel_words(wheel: Wheel) -> str:
    """Its inertia, its axis and its mode."""
    return f"{wheel.inertia:.4g} kg m^2 about {_vector(wheel.axis)}, {wheel.mode}"


def sensor_lines(robot: Robot) -> Iterator[str]:
    """A line for each sensor that the robot file declares, in SI."""
    for name, sensor in robot.sensors.declared.items():
        section = sensor.model_dump(by_alias=True, exclude_none=True)
        entries = {"rate": robot.sensors.rate} | section
        # Zero is what the file leaves out.
        told = {key: x for key, x in entries.items() if x is not None and np.any(x)}
        said = (
            f"{key} {_vector(x)}" if isinstance(x, list | tuple) else f"{key} {x:.4g}"
            for key, x in told.items()
        )
        yield f"{name}: {', '.join(said)}"


def _body_words(robot: Robot, body: int) -> str:
    theta = robot.theta[body]
    m = theta[MASS]
    if m <= 0:
        return "no mass"
    com = _vector(theta[FIRST_MOMENT] / m)
    I = inertia_about_com(theta)
    products = I[[0, 0, 1], [1, 2, 2]]
    said = f"I {_vector(np.diag(I))} kg m^2"
    if np.abs(products).max() > SMALL * np.abs(I).max():
        said += f", xy xz yz {_vector(products)}"
    return f"{m:.6g} kg, CM {com} m, {said}"


def _joint_words(joint: Joint) -> str:
    unit, way = joint.unit, "about" if joint.kind == "revolute" else "along"
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
