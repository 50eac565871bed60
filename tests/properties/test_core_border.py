"""Whatever a function of the core is given, it returns or raises: nothing else happens.

Every function is called with one argument spoiled: numbers that are not finite, other
shapes and types, more rows than any memory holds, counts out of range, objects of
another robot. What comes of it is handed on to the functions that take such. Under
sanitizers nothing is read or written outside either.
"""

import inspect
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from core_calls import Call, core_calls
from random_robots import random_robot, random_wheels

from orbident import _core

pytestmark = pytest.mark.core

NUMBERS = (np.nan, np.inf, -np.inf, 1e300, -1e300, 5e-324, 0.0, -1.0, 0.5, 1e10)
COUNTS = (-(2**31), -1, 0, 1, 2, 3, 2**31 - 1, 2**40)
BEYOND = 2**44
"""Rows that no memory holds, of an array that takes none."""


def spoiled(value: Any, others: dict[type, Any]) -> Iterator[Any]:
    """What may stand in place of an argument."""
    yield from (None, "q", object())
    if isinstance(value, np.ndarray):
        yield from spoiled_arrays(value)
    elif isinstance(value, int):
        yield from COUNTS
    elif isinstance(value, float):
        yield from NUMBERS
    elif isinstance(value, list):
        yield from ([], value[:-1], [*value, *value[:1]])
        yield from ([one, *value[1:]] for one in spoiled(value[0], others))
    elif isinstance(value, tuple):
        for k, part in enumerate(value):
            before, after = value[:k], value[k + 1 :]
            yield from ((*before, one, *after) for one in spoiled(part, others))
    elif type(value) in others:
        yield others[type(value)]


def spoiled_arrays(value: np.ndarray) -> Iterator[np.ndarray]:
    """The same shape with other numbers, and other shapes and types."""
    for number in NUMBERS:
        one = value.copy()
        one.flat[one.size // 2 :][:1] = number
        yield from (one, np.full_like(value, number))
    yield from (
        value.astype(np.float32),
        value.astype(complex),
        np.zeros_like(value, int),
    )
    yield from (value[None], np.zeros(()), np.zeros(0), np.zeros((0,) * value.ndim))
    yield np.broadcast_to(0.0, (BEYOND, *value.shape[1:]))
    yield value.T
    for axis, size in enumerate(value.shape):
        yield value.take(range(1, size), axis)
        yield np.repeat(value, 2, axis)
        yield value.take([], axis)


def tried(call: Call, place: int, value: Any) -> Any:
    """What a call returns with one argument in place of its own; None if it refuses."""
    given = (*call.arguments[:place], value, *call.arguments[place + 1 :])
    try:
        return call.again(given)
    except (TypeError, ValueError, MemoryError):
        return None


def test_whatever_is_given_is_borne_or_refused():
    calls = core_calls(random_robot(1, (0, 1), (1,), random_wheels(1, ["held"])))
    other = core_calls(
        random_robot(2, (0, 0, 1, 2), (), random_wheels(2, ["held", "held", "held"]))
    )
    kinds = {kind for _, kind in inspect.getmembers(_core, inspect.isclass)}
    others = {type(x): x for call in other for x in call.arguments if type(x) in kinds}
    taking = {
        kind: [
            (c, k) for c in calls for k, x in enumerate(c.arguments) if type(x) is kind
        ]
        for kind in kinds
    }
    count = Counter()
    for call in calls:
        for place, argument in enumerate(call.arguments):
            for value in spoiled(argument, others):
                found = tried(call, place, value)
                count[call.name] += 1
                for made in found if isinstance(found, tuple) else (found,):
                    for user, where in taking.get(type(made), ()):
                        tried(user, where, made)
                        count[user.name] += 1
    print(count.total(), "calls")
    functions = {name for name in dir(_core) if not name.startswith("_")}
    unmade = {"FilterState", "RateLaws"}
    assert {name.split(".")[0] for name in count} >= functions - unmade - {
        "give_back_memory"
    }
