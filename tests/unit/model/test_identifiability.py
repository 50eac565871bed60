import re
from dataclasses import replace

from random_robots import random_robot, random_wheels

from orbident.model.formulas import not_identifiable
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot


def sentences(robot: Robot) -> list[str]:
    return not_identifiable(robot, minimal_sets(robot))


def about(robot: Robot, body: str) -> list[str]:
    return [text for text in sentences(robot) if text.startswith(f"{body}:")]


def symbols(text: str) -> set[str]:
    return set(re.findall(r"\b(?:m[xyz]?|I[xyz]{2})\b", text.split(":", 1)[1]))


def test_without_wheels_there_is_no_scale():
    robot = random_robot(0, (0, 1))
    assert "reaction wheel" in sentences(robot)[0]
    with_wheels = replace(robot, wheels=random_wheels(0, ("held",)))
    assert not any("reaction wheel" in text for text in sentences(with_wheels))


def test_planar_motion_shows_neither_height_nor_tilt():
    robot = load_robot("cepheus-like")
    unseen = {"mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz"}
    for body in robot.bodies:
        # Of the links' first moment y and z are zero by their structure.
        known = {"mz"} if body != "base" else set()
        found = about(robot, body)
        assert symbols(found[0]) == unseen - known


def test_joint_on_an_axis_through_S_hides_the_link_along_it():
    """A link's mass cannot be told from the parent's first moment and inertia."""
    robot = random_robot(0, (0,), wheels=random_wheels(0, ("held",)))
    (base,), (link,) = about(robot, "base"), about(robot, "link1")
    assert "combination" in base
    assert "combination" in link
    assert "m" in symbols(link)


def test_a_rigid_body_is_seen_alone():
    """Nothing is mixed with anything: no sentence about the base."""
    robot = random_robot(0, (), wheels=random_wheels(0, ("held",)))
    assert about(robot, "base") == []


def test_known_parameters_are_not_mentioned():
    robot = load_robot("paper-spatial")
    named = {body: set() for body in robot.bodies}
    for body in robot.bodies:
        for text in about(robot, body):
            named[body] |= symbols(text)
    for body in robot.bodies[1:]:
        known = robot.structure[body].zero_parameters()
        assert not named[body] & known
