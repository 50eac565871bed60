"""A robot file to begin with: it loads as it is, and says what to edit."""

import json
import math
import re

from orbident.robot.description import Joint, Robot
from orbident.robot.parameters import inertia_matrix

_HEAD = """\
# A robot file of Orbident. It loads as it is: replace every number by your robot's,
# and see what you have with `orbident check`. Numbers without a unit are SI. Lengths,
# angles, masses and inertias of bodies may have one: 250 mm, 90 deg, 350 g, 4.2e8
# g mm^2. They are nominal (CAD): a starting point, never the answer.
schema: orbident/robot/1
name: {name}
motion: spatial                 # or planar: on a table, all turns about base z
feature_point: [0, 0, 0.5]      # S, the point that is tracked, in the base's frame, m
"""

_BODIES = """
# The base has no parent. Every other body hangs on a joint: xyz is where the joint is
# in the parent's frame, rpy turns the parent's axes into the body's (roll, pitch, yaw
# about fixed axes), axis is the joint's in the body's axes. A body's frame is at its
# joint. com is the CM in this frame, and the inertia is about the CM: [xx, yy, zz], or
# {{xx: .., yy: .., zz: .., xy: .., xz: .., yz: ..}} where xy is -(integral of x y dm).
bodies:
  base: {{mass: 100 kg, com: [0, 0, 0], inertia: [16, 16, 16]}}
"""

_BODY = """\
  link{k}:
    parent: {parent}
    joint: joint{k}               # as the recording calls it
    type: revolute              # revolute, prismatic or fixed
    axis: {axis}
    xyz: {xyz}
    rpy: [0, 0, 0]
    mass: 5 kg
    com: [0.2, 0, 0]
    inertia: [0.01, 0.1, 0.1]   # kg m^2
"""

_TABLE = """
# After Denavit and Hartenberg a row puts frame i behind frame i - 1 by
#   standard:  Rz(theta) Tz(d) Tx(a) Rx(alpha), joint i about z of frame i - 1
#   modified:  Rx(alpha) Tx(a) Rz(theta) Tz(d), joint i about z of frame i (Craig)
# The joint's angle is added to theta, or its way to d if it is prismatic. com and
# inertia (about the CM) of a link are in its frame i: [xx, yy, zz], or
# {{xx: .., yy: .., zz: .., xy: .., xz: .., yz: ..}} where xy is -(integral of x y dm).
# A robot with two arms needs `bodies:` instead of `dh:`.
dh:
  convention: standard          # or modified
  base:                         # xyz and rpy: frame 0 in the base's frame
    mass: 100 kg
    com: [0, 0, 0]
    inertia: [16, 16, 16]
    xyz: [0.5, 0, 0]
    rpy: [0, 0, 0]
  rows:
"""

_ROW = """\
    - joint: joint{k}             # as the recording calls it
      type: revolute            # or prismatic
      a: {a}
      alpha: {alpha} deg
      d: 0
      theta: 0 deg
      mass: 5 kg
      com: [{com}, 0, 0]
      inertia: [0.01, 0.1, 0.1]   # kg m^2
"""

_WHEELS = """
# Inertia about the axis, kg m^2. Mass and inertia are counted in the base already.
wheels:
"""

_TAKEN = ("\n# Joints that were taken for reaction wheels by their names.\nwheels:\n",)

_NO_WHEELS = (
    "\n# Inertia about the axis, kg m^2. Mass and inertia are counted in the base.\n",
    "# wheels:\n",
    "#  - {name: rw_x, axis: [1, 0, 0], inertia: 0.02}\n",
)

_LIMITS = """
# rad and rad/s; m and m/s of a prismatic joint.
limits:
"""

_LIMIT = "  joint{k}: {{position: [-2.0, 2.0], velocity: 0.35}}\n"

_SENSORS = """
# What is measured, how often and how well; what is absent is not measured.
sensors:
  rate: 20 Hz
  gyro: {{angle_random_walk: 0.15 deg/sqrt(h), bias_instability: 0.5 deg/h}}
  attitude: {{angle: 0.02 deg}}
  position: {{std: 0.1 mm}}
  joints: {{position: 0.1 mrad}}
{wheels}"""

_MEASURED = "  wheels: {position: 0.1 mrad}\n"

_TAIL = """
# What may act from outside, and how large it may be, such as {pull: 100 urad} on a
# table; [] if you know that nothing does. Without this line it is what may act in the
# robot's world, and deviations hold it.
# disturbances: []

# What else may stand here is in the reference "The robot file": what is known of bodies
# (structure), motors behind gears (rotors), thrusters, calibration errors (tolerances).
"""

_OF_MODEL = """\
# A robot file of Orbident beside a model, for what the model cannot say. It loads as
# it is: edit it, and see what you have with `orbident check`. Numbers without a unit
# are SI. Masses and inertias of the model are nominal (CAD): a starting point, never
# the answer.
schema: orbident/robot/1
name: {name}
model: {model}
motion: spatial                 # or planar: on a table, all turns about base z
feature_point: [0, 0, 0]        # S, the point that is tracked, in the base's frame, m
# The base is {base}, of {mass:.4g} kg. Where the model is of an arm alone, say what
# carries the arm:
# base: {{mass: 100 kg, com: [0, 0, 0], inertia: [16, 16, 16]}}
"""

_WHEEL_NAME = re.compile(r"wheel|(^|[_.-])rw(?![a-z])", re.IGNORECASE)


def new_robot_text(name: str, joints: int, wheels: int, *, table: bool = False) -> str:
    """A commented robot file of an arm of equal links, whose axes alternate.

    The first three wheels are along x, y and z, more are skew. A DH table may stand
    instead of bodies.
    """
    parts = [
        _HEAD.format(name=json.dumps(name)),
        _arm_table(joints) if table else _arm(joints),
    ]
    if wheels:
        parts += [_WHEELS, *(_wheel(k) for k in range(1, wheels + 1))]
    parts.append(_LIMITS)
    parts += [_LIMIT.format(k=k) for k in range(1, joints + 1)]
    measured = _MEASURED if wheels else ""
    return "".join((*parts, _SENSORS.format(wheels=measured), _TAIL))


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
        lines.append(f"  - {{joint: {json.dumps(joint.name)}{own}}}{why}\n")
    head = _OF_MODEL.format(
        name=json.dumps(robot.name),
        model=json.dumps(model),
        base=robot.bodies[0],
        mass=robot.theta[0, 0],
    )
    parts = [head, *(_TAKEN if wheels else _NO_WHEELS), *lines]
    limits = [_limit_of(joint) for joint in joints]
    if limits:
        said = any(line.startswith("  ") for line in limits)
        parts += [
            _LIMITS if said else _LIMITS.replace("\nlimits", "\n# limits"),
            *limits,
        ]
    sensors = _SENSORS.format(wheels=_MEASURED).lstrip("\n").splitlines(keepends=True)
    parts += ["\n", *(f"# {line.removeprefix('# ')}" for line in sensors), _TAIL]
    return "".join(parts), tuple(wheels)


def _limit_of(joint: Joint) -> str:
    """As the model has them; a comment where it does not say all."""
    low, high = joint.position or (-math.inf, math.inf)
    bounded = math.isfinite(low) and math.isfinite(high)
    position = f"[{low:.6g}, {high:.6g}]" if bounded else "[-2.0, 2.0]"
    velocity = "0.35" if joint.velocity is None else f"{joint.velocity:.6g}"
    line = f"{json.dumps(joint.name)}: {{position: {position}, velocity: {velocity}}}"
    if bounded and joint.velocity is not None:
        return f"  {line}\n"
    return f"#  {line}   # the model does not say all of it\n"


def _arm(joints: int) -> str:
    text = _BODIES.format()
    for k in range(1, joints + 1):
        first = k == 1
        text += _BODY.format(
            k=k,
            parent="base" if first else f"link{k - 1}",
            axis="[0, 0, 1]" if k % 2 else "[0, 1, 0]",
            xyz="[0.5, 0, 0]" if first else "[0.4, 0, 0]",
        )
    return text


def _arm_table(joints: int) -> str:
    # The second joint is across the first, and the others alternate.
    return _TABLE.format() + "".join(
        _ROW.format(k=k, a=0.4, alpha=90 if k % 2 else -90, com=-0.2)
        for k in range(1, joints + 1)
    )


def _wheel(k: int) -> str:
    axes = {1: (1, 0, 0), 2: (0, 1, 0), 3: (0, 0, 1)}
    turn = math.radians(90 * k - 45)
    axis = axes.get(k, (round(math.cos(turn)), round(math.sin(turn)), 1))
    return f"  - {{name: rw{k}, axis: {list(axis)}, inertia: 0.02}}\n"
