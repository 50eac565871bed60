"""What is odd about a robot, in words: what its file may have forgotten or slipped."""

from collections import defaultdict
from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    SYMBOLS,
    Structure,
    inertia_about_com,
    inertia_matrix,
)
from orbident.robot.sensor_schema import GyroSpec

ROUNDING = 1e-9
"""Relative to the largest principal moment: point masses and rods lie exactly on
the border, and files print few digits."""

SLIPS = [10.0 ** (sign * n) for n in range(1, 7) for sign in (-1, 1)]
"""What a decimal point that slipped, or a forgotten exponent, makes of a number."""

MOST_SLIPS = 3
"""Where more are possible, none is likely."""


def nonphysical(
    link: str, mass: float, I_com: Float[np.ndarray, "3 3"]
) -> tuple[str, ...]:
    """What no body can have: one sentence a fault, none for a physical body.

    The mass is in kg, the inertia about the CM in kg m^2; its axes are those of the
    file, where a decimal point may have slipped in one of its numbers.
    """
    a, b, c = np.linalg.eigvalsh(I_com)
    largest = max(abs(a), abs(c))
    faults = []
    if mass < 0:
        faults.append(f"link '{link}': the mass {mass:.6g} kg is negative")
    if mass == 0 and largest > 0:
        faults.append(
            f"link '{link}': it has no mass but principal moments "
            f"{_numbers(a, b, c)} kg m^2"
        )
    if a < -ROUNDING * largest:
        faults.append(
            f"link '{link}': principal moments {_numbers(a, b, c)} kg m^2, "
            f"the smallest is negative{_slipped(I_com)}"
        )
    elif a + b < c - ROUNDING * largest:
        # Six digits may hide a small violation: "1 + 2 < 3".
        digits = 6 if f"{a + b:.6g}" != f"{c:.6g}" else 12
        x, y, z = (f"{value:.{digits}g}" for value in (a, b, c))
        faults.append(
            f"link '{link}': principal moments {x}, {y}, {z} kg m^2 violate "
            f"the triangle inequality ({x} + {y} < {z}){_slipped(I_com)}"
        )
    return tuple(faults)


def _slipped(I_com: Float[np.ndarray, "3 3"]) -> str:
    """Which number would make the inertia possible if its decimal point slipped."""
    found = list(_slips(I_com))
    if not 0 < len(found) <= MOST_SLIPS:
        return ""
    return f"; did a decimal point slip? possible would be {' or '.join(found)}"


def _slips(I_com: Float[np.ndarray, "3 3"]) -> Iterator[str]:
    for i, j in zip(*np.triu_indices(3), strict=True):
        for factor in SLIPS:
            I = I_com.copy()
            I[i, j] = I[j, i] = factor * I_com[i, j]
            a, b, c = np.linalg.eigvalsh(I)
            if a >= 0 and a + b >= c:
                yield f"i{'xyz'[i]}{'xyz'[j]} = {I[i, j]:.6g} (times {factor:g})"
                if i != j:
                    # Any smaller product of inertia is possible too.
                    break


def _numbers(*values: float) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


TOLERANCE = 1e-6
"""Relative to the length of the first moment, and to the trace of the inertia."""

_PRODUCTS = [SYMBOLS.index(name) for name in ("Ixy", "Ixz", "Iyz")]


def contradictions(
    bodies: tuple[str, ...],
    theta: Float[np.ndarray, "bodies 10"],
    structure: Mapping[str, Structure],
) -> tuple[str, ...]:
    """One sentence for each body and kind of knowledge that theta contradicts.

    Raises:
        InputError: a body that is said to be massless, or a rotor alone, is none.
    """
    warnings = []
    for body, theta_i in zip(bodies, theta, strict=True):
        known = structure.get(body, Structure())
        empty = known.massless or known.spins_about
        if empty and (theta_i.any() or body == bodies[0]):
            what = "massless" if known.massless else "spins_about"
            raise InputError(
                f"structure: {body}: {what}, but it is the base or has a nominal "
                "mass or inertia; leave out one"
            )
        s = theta_i[FIRST_MOMENT]
        off_axis = np.linalg.norm(s[[axis != known.com_on_axis for axis in "xyz"]])
        if known.com_on_axis is not None and off_axis > TOLERANCE * np.linalg.norm(s):
            com = s / (theta_i[MASS] or 1.0)
            warnings.append(
                f"structure: {body}: com_on_axis: {known.com_on_axis}, but the nominal "
                f"CM is at [{_numbers(*com)}] m"
            )
        trace = np.trace(inertia_matrix(theta_i))
        products = theta_i[_PRODUCTS]
        if known.principal_axes and np.abs(products).max() > TOLERANCE * abs(trace):
            warnings.append(
                f"structure: {body}: principal_axes, but the nominal products of "
                f"inertia are [{_numbers(*products)}] kg m^2 (xy, xz, yz)"
            )
    return tuple(warnings)


FAR = 10.0
"""A tracked point is usually on the base: it is far where it is so many times further
from the base's CM than the base is large, by its radius of gyration."""

LARGE = 2.0
"""Times the longest way between two joints, or to its CM: a link whose radius of
gyration is larger has the inertia of something else."""

SEVERAL = 3
"""Bodies that have something in common which one or two may have by chance."""

TILTED = 1e-6
"""How far a cosine may be from that of the plane: files print few digits."""


def oddities(robot: Robot) -> tuple[str, ...]:
    """One sentence for each; `Robot.warnings`, of inertias and the like, come first."""
    return (
        *robot.warnings,
        *_run(robot),
        *_massless(robot),
        *_left_by_an_exporter(robot),
        *_out_of_plane(robot),
        *_without_limits(robot),
        *_flat(robot),
        *not_shown(robot),
        *odd_sensors(robot),
        *_far_point(robot),
    )


def odd_sensors(robot: Robot) -> tuple[str, ...]:
    """What is odd about the sensors: a sentence for each."""
    return (*_without_sensors(robot), *_taken_as_exact(robot))


def _run(robot: Robot) -> Iterator[str]:
    model = str(robot.document.get("model") or robot.document.get("urdf"))
    if model.lower().endswith(".xacro"):
        yield (
            f"{model} is a xacro file, whose expressions are run as a program: use it "
            "only if you trust it, or give the URDF that it expands to"
        )


def _massless(robot: Robot) -> Iterator[str]:
    names = [
        body for body, theta in zip(robot.bodies, robot.theta, strict=True)
        if not theta.any() and robot.structure.get(body, Structure()).has_mass
    ]  # fmt: skip
    if names:
        yield (
            f"no mass: {listed(names)}: what moves there has a nominal mass of zero; "
            "give its mass, CM and inertia unless it only carries another joint"
        )


def _left_by_an_exporter(robot: Robot) -> Iterator[str]:
    """Inertias and CMs of moving bodies that nobody has worked out."""
    moving = {
        robot.bodies[k]: (joint, robot.theta[k])
        for k, joint in enumerate(robot.joints, start=1)
        if robot.theta[k, MASS] > 0
    }
    carrying = {robot.bodies[joint.parent] for joint in robot.joints}
    longest = max(
        (float(np.linalg.norm(joint.p_PJ)) for joint, _ in moving.values()), default=0.0
    )
    for name, (_, theta) in moving.items():
        size = np.sqrt(np.trace(inertia_about_com(theta)) / 2 / theta[MASS])
        com = float(np.linalg.norm(theta[FIRST_MOMENT])) / theta[MASS]
        if size > LARGE * max(longest, com) > 0:
            yield (
                f"{name}: {theta[MASS]:.3g} kg with a radius of gyration of "
                f"{size:.2g} m, and joints are {longest:.2g} m apart at most: is its "
                "inertia of a heavier body?"
            )
    copied = defaultdict[tuple[float, ...], list[str]](list)
    for name, (_, theta) in moving.items():
        copied[tuple(inertia_about_com(theta).round(9).ravel())].append(name)
    masses = {name: theta[MASS] for name, (_, theta) in moving.items()}
    for names in copied.values():
        if len(names) >= SEVERAL and len({masses[name] for name in names}) > 1:
            same = "have different masses and the same inertia: was it copied?"
            yield f"{listed(names)} {same}"
    # What turns on the base alone may be a wheel, which is balanced.
    at_joint = [
        name
        for name, (joint, theta) in moving.items()
        if not theta[FIRST_MOMENT].any() and (joint.parent or name in carrying)
    ]
    if len(at_joint) >= SEVERAL:
        yield f"{listed(at_joint)} have their CMs at their joints: was it left out?"


def _out_of_plane(robot: Robot) -> Iterator[str]:
    if robot.motion != "planar":
        return
    names = [
        joint.name
        for joint, along_z in zip(robot.joints, _along_z(robot), strict=True)
        if (1.0 - along_z if joint.kind == "revolute" else along_z) > TILTED
    ]
    names += [wheel.name for wheel in robot.wheels if 1.0 - abs(wheel.axis[2]) > TILTED]
    if names:
        yield (
            f"motion: planar, but {listed(names)} turn about another axis than base z, "
            "or slide out of the plane; correct the axes, or give motion: spatial"
        )


def _along_z(robot: Robot) -> list[float]:
    """The cosine between each joint's axis and base z, of either sign."""
    R, cosines = [np.eye(3)], []
    for joint in robot.joints:
        R.append(R[joint.parent] @ joint.R_PJ)
        cosines.append(float(abs(R[-1] @ joint.axis)[2]))
    return cosines


def _flat(robot: Robot) -> Iterator[str]:
    turning = all(joint.kind == "revolute" for joint in robot.joints)
    if robot.motion == "planar" or len(robot.joints) < 2 or not turning:
        return
    if 1.0 - min(_along_z(robot)) <= TILTED:
        yield (
            "motion: spatial, but all joints turn about base z: if the robot floats on "
            "a table, give motion: planar"
        )


def _without_limits(robot: Robot) -> Iterator[str]:
    driven = [joint for joint in robot.joints if joint.name not in robot.passive]
    unlimited = {
        "range": [joint.name for joint in driven if joint.position is None],
        "rate": [joint.name for joint in driven if joint.velocity is None],
    }
    for what, names in unlimited.items():
        if names:
            yield (
                f"no limit of the {what}: {listed(names)}: 'excite' may move them as "
                "far or as fast as it likes; add it under limits"
            )


def shows_scale(robot: Robot) -> bool:
    """Whether any momentum or torque of a known size gives `pi` its scale (Eq. 24)."""
    torques = robot.sensors.torques or robot.torque_constants
    return bool(robot.wheels or robot.thrusters or robot.torquers or torques)


def not_shown(robot: Robot) -> tuple[str, ...]:
    """What of `pi`, `phi` and the mass its instruments do not show: at most a sentence.

    The velocity of S shows `phi` (Eq. 31), a momentum that is known gives `pi` its
    scale (Eq. 24), and the mass takes both (Eq. 32). Where the file declares no sensor
    at all, nobody knows which there are.
    """
    known, shown, unseen, needed = robot.sensors.declared, ["pi"], [], []
    if not shows_scale(robot):
        shown, unseen = ["ratios of pi"], ["the scale of pi"]
        needed.append(
            "wheels (joints that are wheels), thrusters, or torque sensors at joints"
        )
    if known and not {"position", "accelerometer"} & set(known):
        unseen.append("phi")
        needed.append("position or accelerometer under sensors")
    elif known:
        shown.append("phi")
    if not unseen:
        return ()
    return (
        f"its instruments show {' and '.join(shown)}, but for "
        f"{', '.join(unseen)} and the mass 'identify' needs {'; and '.join(needed)}",
    )


def _without_sensors(robot: Robot) -> Iterator[str]:
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
    if missing:
        yield (
            f"sensors: nothing is said of {', '.join(missing)}: 'simulate' leaves them "
            "out, and 'excite' and 'inspect --trajectory' do not know how good they "
            "are; add them under sensors"
        )


def _taken_as_exact(robot: Robot) -> Iterator[str]:
    gyro, known = robot.sensors.gyro or GyroSpec(), robot.tolerances
    missing = {
        what: float(np.max(np.abs(error)))
        for what, error, tolerance in (
            ("misalignment", gyro.misalignment, known.gyro_misalignment),
            ("scale", gyro.scale, known.gyro_scale),
        )
        if error is not None and np.any(error) and not tolerance
    }
    if missing:
        add = ", ".join(f"{what}: {size:g}" for what, size in missing.items())
        yield (
            f"sensors: 'simulate' adds an error of {' and '.join(missing)} to the "
            "gyro, which 'identify' takes as exact without a tolerance, so that it "
            f"refuses the recording; add tolerances: {{gyro: {{{add}}}}}"
        )


def _far_point(robot: Robot) -> Iterator[str]:
    # The base's body frame is at S.
    theta = robot.theta[0]
    m = theta[MASS]
    if m <= 0:
        return
    distance = float(np.linalg.norm(theta[FIRST_MOMENT]) / m)
    about_S = float(theta[[4, 6, 9]].sum()) / 2
    size = np.sqrt(max(about_S / m - distance**2, 0.0))
    if size and distance > FAR * size:
        yield (
            f"feature_point: S is {distance:.4g} m from the base's CM, while the "
            f"base's radius of gyration is {size:.2g} m; give it in m, in the base "
            "link's frame"
        )
