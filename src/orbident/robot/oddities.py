"""What is odd about a robot though it loads: what its file may have forgotten."""

import numpy as np

from orbident.files.names import listed
from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS
from orbident.robot.sensor_schema import GyroSpec

FAR = 10.0
"""A tracked point is usually on the base: it is far where it is so many times further
from the base's CM than the base is large, by its radius of gyration."""

TILTED = 1e-6
"""How far a cosine may be from that of the plane: files print few digits."""


def oddities(robot: Robot) -> tuple[str, ...]:
    """One sentence for each; `Robot.warnings`, of inertias and the like, come first.

    Args:
        robot: with its nominal inertia.
    """
    return (
        *robot.warnings,
        *_run(robot),
        *_massless(robot),
        *_out_of_plane(robot),
        *_without_limits(robot),
        *_flat(robot),
        *_without_wheels(robot),
        *odd_sensors(robot),
        *_far_point(robot),
    )


def odd_sensors(robot: Robot) -> tuple[str, ...]:
    """What is odd about the sensors: a sentence for each."""
    return (*_without_sensors(robot), *_taken_as_exact(robot))


def _run(robot: Robot) -> list[str]:
    model = str(robot.document.get("model") or robot.document.get("urdf"))
    if not model.lower().endswith(".xacro"):
        return []
    return [
        f"{model} is a xacro file, whose expressions are run as a program: use it only "
        "if you trust it, or give the URDF that it expands to"
    ]


def _massless(robot: Robot) -> list[str]:
    names = [
        body for body, theta in zip(robot.bodies, robot.theta, strict=True)
        if not theta.any()
    ]  # fmt: skip
    if not names:
        return []
    return [
        f"no mass: {listed(names)}: what moves there has a nominal mass of zero; give "
        "its mass, CM and inertia unless it only carries another joint"
    ]


def _out_of_plane(robot: Robot) -> list[str]:
    if robot.motion != "planar":
        return []
    R = [np.eye(3)]
    names = []
    for joint in robot.joints:
        R.append(R[joint.parent] @ joint.R_PJ)
        along_z = abs(R[-1] @ joint.axis)[2]
        off = 1.0 - along_z if joint.kind == "revolute" else along_z
        names += [joint.name] if off > TILTED else []
    names += [wheel.name for wheel in robot.wheels if 1.0 - abs(wheel.axis[2]) > TILTED]
    if not names:
        return []
    return [
        f"motion: planar, but {listed(names)} turn about another axis than base z, or "
        "slide out of the plane; correct the axes, or give motion: spatial"
    ]


def _flat(robot: Robot) -> list[str]:
    if robot.motion == "planar" or len(robot.joints) < 2:
        return []
    R = [np.eye(3)]
    for joint in robot.joints:
        R.append(R[joint.parent] @ joint.R_PJ)
        if joint.kind != "revolute" or 1.0 - abs(R[-1] @ joint.axis)[2] > TILTED:
            return []
    return [
        "motion: spatial, but all joints turn about base z: if the robot floats on a "
        "table, give motion: planar"
    ]


def _without_limits(robot: Robot) -> list[str]:
    unlimited = {
        "range": [joint.name for joint in robot.joints if joint.position is None],
        "rate": [joint.name for joint in robot.joints if joint.velocity is None],
    }
    return [
        f"no limit of the {what}: {listed(names)}: 'excite' may move them as far or "
        "as fast as it likes; add it under limits"
        for what, names in unlimited.items()
        if names
    ]


def _without_wheels(robot: Robot) -> list[str]:
    if robot.wheels:
        return []
    return [
        "no wheels: without a momentum that is known, pi has no scale and the mass is "
        "not identified; declare the wheels, or the joints that are wheels"
    ]


def _without_sensors(robot: Robot) -> list[str]:
    known = robot.sensors.declared
    missing = []
    if robot.joints and "joints" not in known:
        missing.append("joints")
    if robot.wheels and "wheels" not in known:
        missing.append("wheels")
    if not {"gyro", "attitude"} & set(known):
        missing.append("gyro or attitude")
    if not {"position", "accelerometer"} & set(known):
        missing.append("position or accelerometer")
    if not missing:
        return []
    return [
        f"sensors: nothing is said of {', '.join(missing)}: 'simulate' leaves them "
        "out, and 'excite' and 'inspect --trajectory' do not know how good they are; "
        "add them under sensors"
    ]


def _taken_as_exact(robot: Robot) -> list[str]:
    gyro, known = robot.sensors.gyro or GyroSpec(), robot.tolerances
    missing = {
        what: float(np.max(np.abs(error)))
        for what, error, tolerance in (
            ("misalignment", gyro.misalignment, known.gyro_misalignment),
            ("scale", gyro.scale, known.gyro_scale),
        )
        if error is not None and np.any(error) and not tolerance
    }
    if not missing:
        return []
    add = ", ".join(f"{what}: {size:g}" for what, size in missing.items())
    return [
        f"sensors: 'simulate' adds an error of {' and '.join(missing)} to the gyro, "
        "which 'identify' takes as exact without a tolerance, so that it refuses the "
        f"recording; add tolerances: {{gyro: {{{add}}}}}"
    ]


def _far_point(robot: Robot) -> list[str]:
    # The base's body frame is at S.
    theta = robot.theta[0]
    m = theta[MASS]
    if m <= 0:
        return []
    distance = float(np.linalg.norm(theta[FIRST_MOMENT]) / m)
    about_S = float(theta[[4, 6, 9]].sum()) / 2
    size = np.sqrt(max(about_S / m - distance**2, 0.0))
    if not size or distance <= FAR * size:
        return []
    return [
        f"feature_point: S is {distance:.4g} m from the base's CM, while the base's "
        f"radius of gyration is {size:.2g} m; give it in m, in the base link's frame"
    ]
