"""A new quantity of a result is one field: it is checked, written and read by its type.

All that `result.json` holds comes back as it was.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_results import exact_result

from orbident.errors import InputError
from orbident.estimation.budget import Budget, SensitivityTable
from orbident.estimation.checks import Check
from orbident.estimation.quantities import MassRoutes, Quantity, TotalMass
from orbident.estimation.result import Result
from orbident.estimation.solution import Step
from orbident.estimation.unknowns import (
    CalibrationFit,
    DisturbanceFit,
    DriveFit,
    SpringFit,
)
from orbident.files.json_parts import Keyed, NullableTable, as_computed
from orbident.identified import run_folder
from orbident.identified.run_folder import load_result, save_result
from orbident.preprocessing.delays import Delay
from orbident.robot.description import Robot

NOT_KEPT = {"solved", "fits", "history", "signals"}


@dataclass(frozen=True, kw_only=True, repr=False)
class LongerResult(Result):
    """A result with four more quantities."""

    flexibility: Quantity
    hysteresis: Keyed[Delay]
    modes: NullableTable
    damped: bool


@pytest.fixture
def longer(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> LongerResult:
    monkeypatch.setattr(run_folder, "Result", LongerResult)
    return LongerResult(
        **vars(exact_result(robot)),
        flexibility=Quantity(2.5, np.nan),
        hysteresis=Delay(0.1, 0.01, True),
        modes=np.array([[1.0, np.nan], [2.0, 3.0], [4.0, 5.0]]),
        damped=True,
    )


def test_a_new_quantity_is_written_and_read(longer: LongerResult, tmp_path: Path):
    document = longer.to_json()
    assert document["flexibility"] == {"value": 2.5, "std": None}
    assert document["hysteresis"] == {"late": 0.1, "std": 0.01, "corrected": True}
    assert document["modes"] == [[1.0, None], [2.0, 3.0], [4.0, 5.0]]
    save_result(longer, tmp_path / "run")
    kept = load_result(tmp_path / "run")
    assert isinstance(kept, LongerResult)
    np.testing.assert_equal(
        [kept.flexibility.value, kept.flexibility.std, kept.modes],
        [2.5, np.nan, longer.modes],
    )
    assert (kept.hysteresis, kept.damped) == (longer.hysteresis, True)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("flexibility", {"value": 1.0, "std": -1.0}, "flexibility.std: found -1.0"),
        ("hysteresis", {"late": 1.0}, "hysteresis.std: this key is missing"),
        ("modes", [[1.0], []], "modes: found [[1.0], []]; rows of one length"),
        ("damped", "hardly", "damped: found 'hardly'; give true or false"),
    ],
)
def test_a_new_quantity_is_checked(
    longer: LongerResult, name: str, value: object, words: str
):
    document = {**longer.to_json(), name: value}
    with pytest.raises(InputError) as caught:
        run_folder.result_from(document, longer.robot, Path("run/result.json"))
    assert words in str(caught.value)


def full(robot: Robot) -> Result:
    """A result in which no field has its default, and NaN stands wherever it may."""
    made, nan = exact_result(robot), np.nan
    two, names = np.array([1.5, nan]), made.base.names
    routes = MassRoutes(("M by x", "M by y"), ("x", ""), two, two, two, 3)
    moved = {"position": [-1.0, 2.5], "rate": 0.5}
    fit = {"rms": 1e-3, "noise": 1e-3, "declared": None, "whiteness": 0.1}
    file = {"file": "a.csv", "sha256": "0", "from": 1.5, "to": 20.0, "seed": 3}
    return replace(
        made,
        mass=TotalMass(1110.0, nan, routes),
        method="recursive",
        initial_momentum="at-rest",
        checks=(
            Check("scale", "with care", "it is small", "spin", 2.5, 1.0),
            Check("whole", "do not trust", "it is none"),
        ),
        notes=("a remark",),
        diagnostics=exact_result(robot, 1).withheld().diagnostics,
        condition_number={"Y": 10.0, "W": nan},
        residual={
            "rms": {"gyro": 1e-3, "a: attitude": None},
            "chi2_per_dof": 0.95,
            "sensors": {"gyro": {**fit, "samples": 1001}},
        },
        convergence=(Step(1e9, nan), Step(1e3, 0.5, 2)),
        biases={"gyro.x": {"value": 1e-4, "std": 1e-6}},
        springs={"panel": SpringFit(0.3, 1e-3, 5e-3, 1e-4)},
        drives={"elbow": DriveFit(1.0, 0.1, 2.0, 0.2, 3.0, 0.3, -4.0, 0.4)},
        calibration={"gyro.scale.x": CalibrationFit(0.1, 0.2, 0.3)},
        disturbances={"drag": DisturbanceFit("drag", "N", 1e-3, 1e-4, 2.0)},
        allowed={"drag": 2e-3, "pull": nan},
        widened_by=2.5,
        sensitivity=as_computed(
            SensitivityTable(names[:2], ("attitude.clock",), ("ms",), two[:, None])
        ),
        budget=as_computed(
            Budget(
                names[:1],
                names[0],
                ("gyro", "drag"),
                ("noise", "recording"),
                shares=np.array([[0.75, 0.25]]),
                costs=np.array([[nan, 2.0]]),
            )
        ),
        clocks={"joints": Delay(0.01, nan, True), "attitude": Delay(0.0, 1e-3, False)},
        rejected={"gyro.x": {"saturated": 3}},
        origins={"attitude": "measured"},
        samples=77,
        motion={
            "duration": 20.0,
            "rate": 50.0,
            "joints": dict.fromkeys(robot.joint_names, moved),
            "wheels": {"rw": {"speed": None}},
            "base": {"z": {"rate": None}},
            "locked": [robot.joint_names[0]],
        },
        input={"recordings": [file, {"file": "b.csv"}]},
        elapsed_s=2.5,
        versions={"numpy": "2"},
    )


def test_every_field_of_a_result_comes_back(robot: Robot, tmp_path: Path):
    found, plain = full(robot), exact_result(robot)
    save_result(found, tmp_path / "run")
    kept = load_result(tmp_path / "run")
    assert kept.to_json() == found.to_json()
    assert (
        kept.to_json().keys() - {"level", "status", "warnings"}
        == {each.name for each in fields(Result)} - NOT_KEPT
    )
    fixed = {"schema", "robot", "pi", "phi", "base", "covariance"}
    computed = {"sensitivity", "budget"}
    for each in fields(Result):
        name = each.name
        if name in NOT_KEPT | {"robot"}:
            continue
        mine, theirs = getattr(found, name), getattr(kept, name)
        if name in computed:
            mine, theirs = mine(), theirs()
        np.testing.assert_equal(plain_data(theirs), plain_data(mine), err_msg=name)
        # A field that is added here is to be made up above.
        if name not in fixed | computed:
            assert repr(mine) != repr(getattr(plain, name)), name


def plain_data(value: Any) -> Any:
    """Dictionaries and sequences in place of objects, arrays as they are."""
    if is_dataclass(value):
        return {name: plain_data(part) for name, part in vars(value).items()}
    return [*map(plain_data, value)] if type(value) is tuple else value
