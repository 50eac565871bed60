"""A script that builds the identified spacecraft in Basilisk.

The hub has the base with its wheels, which are balanced: Basilisk counts them in the
hub, as Eq. 5 does. An arm is a state effector: a chain of spinning bodies, or one of
translating bodies. There is none in Basilisk for other trees.
"""

from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from pprint import pformat
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.identified.exported_robot import ExportedRobot
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com, transformed

HEAD = '''\
"""The spacecraft {name} for Basilisk, as Orbident {version} identified it.

Run this file for a short free flight, or import it and add what `build()` returns to a
task of your own. SI units. Frame B is that of the base link.
"""

import numpy as np
from Basilisk.simulation import (
    linearTranslationNDOFStateEffector,
    reactionWheelStateEffector,
    spacecraft,
    spinningBodyNDOFStateEffector,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW

'''

ELSEWHERE = "export a .xml, which Basilisk's MuJoCo scenes read"


def basilisk_script(made: ExportedRobot) -> str:
    """The text of the script.

    Raises:
        InputError: an arm branches, or has joints that turn and joints that slide.
    """
    robot = made.robot
    hub = transformed(robot.theta[0], np.eye(3), robot.feature_point)
    wheels = [
        {"name": w.name, "axis": w.axis.tolist(), "inertia": float(w.inertia)}
        for w in robot.wheels
    ]
    arms = [
        [_link(made, k) for k in _arm(robot, first)]
        for first, joint in enumerate(robot.joints)
        if joint.parent == 0
    ]
    data = {
        "NAME": robot.name,
        "HUB": _mass(hub),
        "ARMS": arms,
        "WHEELS": wheels,
        "FEATURE_POINT": robot.feature_point.tolist(),
    }
    lines = [f"{key} = {pformat(x, sort_dicts=False)}" for key, x in data.items()]
    code = files("orbident.identified").joinpath("template/basilisk.txt").read_text()
    # A name may hold quotes.
    name = "".join(c for c in robot.name if c.isalnum() or c in " -_.")
    head = HEAD.format(name=name, version=version("orbident"))
    return "\n".join([head, *lines, code])


def _arm(robot: Robot, first: int) -> Iterator[int]:
    """The joints of an arm, from the hub on.

    Raises:
        InputError: as `basilisk_script`.
    """
    at = first
    while True:
        if robot.joints[at].kind != robot.joints[first].kind:
            raise InputError(
                f"{robot.name}: joint '{robot.joints[at].name}' slides where others of "
                "its arm turn, or the other way round, which Basilisk's arms cannot; "
                f"{ELSEWHERE}"
            )
        yield at
        beyond = [k for k, each in enumerate(robot.joints) if each.parent == at + 1]
        if len(beyond) > 1:
            raise InputError(
                f"{robot.name}: two joints are on body '{robot.bodies[at + 1]}', but "
                f"Basilisk's arms have no branches; {ELSEWHERE}"
            )
        if not beyond:
            return
        at = beyond[0]


def _link(made: ExportedRobot, k: int) -> dict[str, Any]:
    joint = made.mechanism.joints[k]
    return {
        "joint": joint.name,
        "kind": joint.kind,
        "position": joint.p_PJ.tolist(),
        "rotation": joint.R_PJ.tolist(),
        "axis": joint.axis.tolist(),
        **_mass(made.robot.theta[k + 1]),
    }


def _mass(theta: Float[np.ndarray, "10"]) -> dict[str, Any]:
    return {
        "mass": float(theta[MASS]),
        "com": (theta[FIRST_MOMENT] / theta[MASS]).tolist(),
        "inertia": inertia_about_com(theta).tolist(),
    }
