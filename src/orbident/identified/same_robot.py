"""Whether two results are of one robot: what momentum depends on, inertia apart."""

from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.robot.description import Joint, Robot, Wheel

TOLERANCE = 1e-9
"""Relative, and in m: what a change of a file's digits may do."""


def check_same_robot(before: Robot, after: Robot) -> None:
    """Refuse robots that differ in geometry, joints, wheels or feature point.

    Raises:
        InputError: they differ; the first difference is named.
    """
    difference = _of_names(before, after) or _of_numbers(before, after)
    if difference:
        raise InputError(
            f"the robots differ: {difference}; give two results of one robot, which "
            "may differ in inertia and structure alone"
        )


def _of_names(before: Robot, after: Robot) -> str | None:
    for what, a, b in (
        ("body", before.bodies, after.bodies),
        ("joint", before.joint_names, after.joint_names),
        ("wheel", before.wheel_names, after.wheel_names),
    ):
        for name in a:
            if name not in b:
                return f"{what} '{name}' is in the run before only"
        for name in b:
            if name not in a:
                return f"{what} '{name}' is in the run after only"
        if a != b:
            return f"{what} order: {listed(a)} before, {listed(b)} after"
    return None


def _of_numbers(before: Robot, after: Robot) -> str | None:
    pairs = [("robot", _of_robot(before), _of_robot(after))]
    pairs += [
        (f"joint '{a.name}'", _of_joint(before, a), _of_joint(after, b))
        for a, b in zip(before.joints, after.joints, strict=True)
    ]
    pairs += [
        (f"wheel '{a.name}'", _of_wheel(a), _of_wheel(b))
        for a, b in zip(before.wheels, after.wheels, strict=True)
    ]
    for who, a, b in pairs:
        for what in a:
            if not _equal(a[what], b[what]):
                found = f"{_shown(a[what])} before, {_shown(b[what])} after"
                return f"{who}: {what}: {found}"
    return None


def _of_robot(robot: Robot) -> dict[str, Any]:
    return {"motion": robot.motion, "feature point (m)": robot.feature_point}


def _of_joint(robot: Robot, joint: Joint) -> dict[str, Any]:
    return {
        "kind": joint.kind,
        "parent": robot.bodies[joint.parent],
        "axis": joint.axis,
        "position (m)": joint.p_PJ,
        "rotation matrix": joint.R_PJ,
    }


def _of_wheel(wheel: Wheel) -> dict[str, Any]:
    return {"axis": wheel.axis, "inertia (kg m^2)": wheel.inertia}


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, str):
        return a == b
    # An inertia has no size that would be small for every wheel.
    atol = TOLERANCE if np.ndim(a) else 0.0
    return bool(np.allclose(a, b, rtol=TOLERANCE, atol=atol))


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return value
    if np.ndim(value) == 0:
        return f"{value:.10g}"
    return "[" + ", ".join(f"{x:.10g}" for x in np.ravel(value)) + "]"
