"""Errors of instruments, each kind freed."""

import re

import numpy as np
from cause_problems import clean, fitted, problem_with, with_joint

from orbident.diagnosis.likeliest import ErrorKind, freed, kinds

CLOCK = re.compile(r"\.clock$")


def test_every_error_is_of_one_kind():
    """But for clocks, which are tried in a way of their own."""
    sensitivity = fitted(problem_with()).sensitivity
    assert sensitivity is not None
    names = [*sensitivity().alone]
    known = [name for kind in kinds(clean().robot, ()) for name in kind.names]
    own = [name for name in names if CLOCK.search(name)]
    assert sorted([*(name for name in known if name in names), *own]) == sorted(names)


def _kind(family: str) -> ErrorKind:
    return next(each for each in kinds(clean().robot, ()) if each.family == family)


def test_the_zero_of_a_joint():
    problem = problem_with({"joint.joint1.position": lambda q: q + 0.02})
    (found,) = freed(problem, _kind("joint zeros"))
    assert found.accepted
    assert "the zero of joint joint1 is off by" in found.cause


def test_the_place_of_a_joint():
    """The robot file has joint 1 at 5 mm from where it is."""
    off = np.array([5e-3, 0.0, 0.0])
    p_PJ = clean().robot.joints[0].p_PJ
    problem = problem_with(robot=with_joint(0, p_PJ=p_PJ + off))
    (found,) = freed(problem, _kind("joint.joint1.place"))
    assert found.accepted
    assert "the place of joint joint1" in found.cause
    assert "length of that link, is off by -0.005" in found.cause
    assert "along x" in found.cause
