"""What is said first of a recording that is refused."""

import numpy as np
from cause_problems import problem_with, solved

from orbident.estimation.causes.causes import causes


def reason(problem) -> str:
    (check,) = causes(solved(problem))
    assert check.level == "do not trust"
    return check.reason


def test_a_sign():
    words = reason(problem_with({"joint.joint2.position": np.negative}))
    assert words.startswith("the sign of joint joint2, or of its axis, is the opposite")


def test_a_scale():
    words = reason(problem_with({"joint.joint2.position": lambda q: 1.01 * q}))
    assert words.startswith("the scale of joint joint2 is off by")


def test_what_is_not_understood_says_perhaps():
    random = np.random.default_rng(0)
    wobble = 3e-4 * np.cumsum(random.standard_normal((301, 3)), axis=0)
    words = reason(
        problem_with(
            {
                f"position.{k}": lambda x, i=i: x + np.sin(wobble[: x.size, i])
                for i, k in enumerate("xyz")
            }
        )
    )
    assert "perhaps" in words
