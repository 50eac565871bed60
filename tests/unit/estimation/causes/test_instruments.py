"""Errors of instruments, each kind freed."""

import re

from cause_problems import clean, fitted, problem_with

from orbident.estimation.causes.instruments import freed, kinds

OWN_WAY = re.compile(r"\.clock$|\.place\.|\.direction\.")


def test_every_error_is_of_one_kind():
    """But for clocks and geometry, which are tried in ways of their own."""
    sensitivity = fitted(problem_with()).sensitivity
    assert sensitivity is not None
    names = [each.name for each in sensitivity().freed]
    known = [kind.errors(names) for kind in kinds(clean().robot)]
    found = sorted(k for errors in known for k in errors)
    own = [k for k, name in enumerate(names) if OWN_WAY.search(name)]
    assert sorted([*found, *own]) == [*range(len(names))]


def test_the_zero_of_a_joint():
    problem = problem_with({"joint.joint1.position": lambda q: q + 0.02})
    kind = next(each for each in kinds(clean().robot) if each.error == "zero")
    (found,) = freed(problem, kind)
    assert found.accepted
    assert "the zero of joint joint1 is off by" in found.cause
