"""Objects of other libraries: what is said where there are none."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from made_results import REFUSED, exact_result

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.robot.robot_file import load_robot


@pytest.fixture
def result() -> Result:
    return exact_result(load_robot("cepheus-like"))


@pytest.mark.parametrize("library", ["mujoco", "pinocchio"])
def test_the_extra_is_named(
    result: Result, library: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, library, None)
    words = rf'to_{library}\(\) needs {library}: pip install "orbident\[{library}\]"'
    with pytest.raises(InputError, match=words):
        getattr(result, f"to_{library}")()


@pytest.mark.parametrize("library", ["mujoco", "pinocchio"])
def test_a_rejected_result_is_none(result: Result, library: str):
    with pytest.raises(InputError, match="is refused"):
        getattr(replace(result, checks=(REFUSED,)), f"to_{library}")()


def test_no_bodies(result: Result):
    """A total mass that is negative, with certainty."""
    values = result.base.values.copy()
    values[0] = -1.0
    C = np.diag(np.full(values.size, 1e-20))
    impossible = replace(result, base=replace(result.base, values=values, covariance=C))
    with pytest.raises(InputError, match="no bodies that can exist"):
        impossible.to_mujoco()
