"""A child process gives what the function gives, and ends where it takes too much."""

import builtins
import math
import operator
import os
import sys
import time

import pytest
from processes import finished

from orbident.errors import InputError
from orbident.files.confined import ConfinedError, confined
from orbident.files.names import listed
from orbident.files.schema_parts import read_yaml_mapping

SMALL = {"seconds": 1, "megabytes": 100}


def test_what_it_gives():
    assert confined(listed, ["a", "é"], **SMALL) == "'a', 'é'"
    numbers = [0.1, 1e-300, math.pi]
    assert confined(operator.mul, numbers, 2, **SMALL) == 2 * numbers


def test_what_libraries_print_is_no_part_of_it(capfd: pytest.CaptureFixture[str]):
    assert confined(builtins.print, "noise", **SMALL) is None
    assert confined(os.system, "echo noise; echo noise >&2", **SMALL) == 0
    assert capfd.readouterr() == ("", "")


def test_a_refusal_comes_through():
    with pytest.raises(InputError, match=r"^a\.yaml: found an empty file"):
        confined(read_yaml_mapping, "", "a.yaml", "orbident/robot/1", **SMALL)


def test_a_mistake_of_the_function_is_no_refusal():
    with pytest.raises(RuntimeError, match="ZeroDivisionError") as caught:
        confined(operator.truediv, 1, 0, **SMALL)
    assert not isinstance(caught.value, ConfinedError)


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (math.factorial, [10**8], "needs more than 1 s of the processor"),
        (operator.mul, ["x", 10**10], "needs more than 100 MB of memory"),
        (os.abort, [], "crashes"),
    ],
)
def test_what_is_stopped(function, arguments, words: str):
    with pytest.raises(ConfinedError, match=f"^{words}$"):
        confined(function, *arguments, **SMALL)


def test_what_waits_is_stopped(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("orbident.files.confined._WAITING", 1)
    with pytest.raises(ConfinedError, match=r"^takes more than 1 s$"):
        confined(time.sleep, 60, **SMALL)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_limits_that_there_are_stay():
    code = (
        "import resource; from orbident.files.confined import confined; "
        "resource.setrlimit(resource.RLIMIT_CPU, (5, 5)); "
        "print(confined(len, [1, 2], seconds=60, megabytes=100))"
    )
    assert finished(sys.executable, "-c", code).stdout == "2\n"
