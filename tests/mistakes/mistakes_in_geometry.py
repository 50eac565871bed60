"""Robot files that are wrong: wheels, links, axes, what is known of the bodies."""

from dataclasses import replace

import numpy as np
from mistake import IN_SPACE, ON_TABLE, Groups, Mistake
from recordings import ROBOTS
from wrong_columns import turned
from wrong_robots import each_wheel, one_joint, really, without_wheel

from orbident.robot.description import Joint, Robot, Wheel

JOINT1, JOINT2 = 0, 1
LINK2 = 2


def heavier(part: float):
    return lambda wheel: replace(wheel, inertia=(1 + part) * wheel.inertia)


def tilted(angle: float):
    def change(wheel: Wheel) -> Wheel:
        R = turned("x" if abs(wheel.axis[0]) < 0.5 else "y", angle)
        return replace(wheel, axis=R @ wheel.axis)

    return change


def moved(x: float):
    return lambda joint: replace(joint, p_PJ=joint.p_PJ + np.array([x, 0.0, 0.0]))


def twisted(axis: str, angle: float):
    return lambda joint: replace(joint, R_PJ=joint.R_PJ @ turned(axis, angle))


def about_the_other_way(joint: Joint) -> Joint:
    return replace(joint, axis=-joint.axis)


def off_its_axis(robot: Robot) -> Robot:
    """The CM of link 2 is 10 mm beside the axis that `structure` says it is on."""
    theta = robot.theta.copy()
    theta[LINK2, 2] += 0.01 * theta[LINK2, 0]
    return replace(robot, theta=theta)


WHEELS = (
    *(
        Mistake(
            f"inertia of all wheels {100 * part:g} % off",
            each_wheel(heavier(part)),
            "inertia wheel",
            unobservable=ROBOTS,
            tolerance={"wheels": {"inertia": part}},
        )
        for part in (0.01, 0.1)
    ),
    Mistake(
        "inertia of one wheel 10 % off",
        each_wheel(heavier(0.1), 1),
        "inertia wheel",
        IN_SPACE,
        tolerance={"wheels": {"inertia": 0.1}},
    ),
)

WHEEL_AXES = (
    Mistake(
        "axis of one wheel 2 deg off",
        each_wheel(tilted(2.0), 1),
        "axes|axis wheel",
        IN_SPACE,
    ),
    Mistake(
        "axis of the wheel 10 deg off",
        each_wheel(tilted(10.0)),
        "axes|axis wheel",
        ON_TABLE,
        unobservable=ON_TABLE,  # its cosine is a gain of 1.5 %
        tolerance={"wheels": {"inertia": 0.015}},
    ),
)

GEOMETRY = (
    *(
        Mistake(
            f"link1 {1000 * x:g} mm longer",
            one_joint(JOINT2, moved(x)),
            "geometry|length|place|placed|placement joint2|link1",
            unobservable=ON_TABLE,
            tolerance={"joints": {"place": x}},
        )
        for x in (1e-3, 1e-2)
    ),
    Mistake(
        "joint1 placed 10 mm off",
        one_joint(JOINT1, moved(0.01)),
        "geometry|place|placed|placement joint1",
        tolerance={"joints": {"place": 0.01}},
    ),
    Mistake(
        "joint2 tilted 1 deg",
        one_joint(JOINT2, twisted("x", 1.0)),
        "geometry|axes|axis|tilt* joint2",
        IN_SPACE,
    ),
    Mistake(
        "joint2 about the opposite axis",
        one_joint(JOINT2, about_the_other_way),
        "sign|axes|axis joint2",
    ),
    Mistake("CM of link2 10 mm off its axis", really(off_its_axis), "structure link2"),
)

IN_GEOMETRY: Groups = {
    "wheel inertia": WHEELS,
    "wheel axis": WHEEL_AXES,
    "missing wheel": (
        Mistake(
            "a wheel is missing", without_wheel, "wheel missing|declare|undeclared"
        ),
    ),
    "geometry of a link": GEOMETRY,
}
