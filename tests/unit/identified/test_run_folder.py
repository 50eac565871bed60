"""What is refused of an edited `result.json`: all that a reader would trip over."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_results import exact_result

from orbident.errors import InputError
from orbident.identified.run_folder import result_from
from orbident.robot.robot_file import load_robot

ROBOT = load_robot("cepheus-like")
PATH = Path("run/result.json")
WRITTEN = json.loads(json.dumps(exact_result(ROBOT).to_json()))
WRITTEN["clocks"] = {"joints": {"late": 0.0, "std": None, "corrected": False}}
WRITTEN["residual"] = {
    "rms": {"attitude": 1e-3},
    "chi2_per_dof": 0.95,
    "sensors": {
        "attitude": {
            **{"rms": 1e-3, "noise": 1e-3, "declared": None, "whiteness": 0.1},
            "samples": 1001,
        }
    },
}
WRITTEN["convergence"] = [
    {"cost": 1e9, "size": None, "round": 1},
    {"cost": 1e3, "size": 1e-3, "round": 1},
]
WRITTEN["motion"] = {
    "duration": 20.0,
    "rate": 50.0,
    "joints": {
        name: {"position": [-1.0, 2.5], "rate": 0.5} for name in ROBOT.joint_names
    },
    "wheels": {"rw": {"speed": None}},
    "base": {"z": {"rate": None}},
    "locked": [],
}


def edited(value: Any, *keys: str | int) -> dict[str, Any]:
    document = copy.deepcopy(WRITTEN)
    place: Any = document
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return document


def check(document: dict[str, Any]) -> None:
    result_from(document, ROBOT, PATH)


def test_what_is_written_is_accepted():
    check(WRITTEN)
    check(edited(None, "motion"))
    check(edited("of a later version", "more"))


def test_of_several_recordings_and_of_parts():
    fit = WRITTEN["residual"]["sensors"]["attitude"]
    check(edited({"first: attitude": 1e-3}, "residual", "rms"))
    check(edited({"first: attitude": fit}, "residual", "sensors"))
    part = {"file": "r.csv", "sha256": "0", "from": 1.5, "to": 20}
    check(edited(part, "input"))
    check(edited({"recordings": [part, {**part, "seed": 1}]}, "input"))


SENSOR = ("residual", "sensors", "attitude")
REFUSED = {
    "an integer of 400 digits": ((10**400, "samples"), "samples: found 1000"),
    "a huge number": ((10**400, "mass", "value"), "mass.value: found 1000"),
    "text for a number": (("heavy", "mass", "value"), "mass.value: found 'heavy'"),
    "text in a form": (("1", "mass", "forms", "values"), "mass.forms.values: found"),
    "text in a residual": (("1", *SENSOR, "noise"), "attitude.noise: found '1'"),
    "an unknown sensor": (({"eye": 1.0}, "residual", "rms"), "residual.rms.eye"),
    "text for a time": (("1", "input"), "input: found '1'"),
    "text for a start": (({"from": "1"}, "input"), "input.from: found '1'"),
    "a number for a list": ((3, "notes"), "notes: found 3; give a"),
    "a number for a name": (([3], "motion", "locked"), "motion.locked[0]: found 3"),
    "a number for joints": ((1, "motion", "joints"), "motion.joints: found 1"),
    "other joints": (({}, "motion", "joints"), "these are not the robot's"),
    "a row less": (
        (WRITTEN["base"]["covariance"][1:], "base", "covariance"),
        "base: the covariance is not 8 by 8",
    ),
    "a short row": (
        ([1.0], "base", "covariance", 0),
        "rows of one length are expected",
    ),
    "a smaller square": (
        ([[1.0]], "base", "covariance"),
        "base: the covariance is not 8 by 8",
    ),
    "half a covariance": (
        ([[1.0], [1.0]], "covariance"),
        "rows that end at the diagonal are expected",
    ),
    "a covariance of others": (
        ([[1.0], [0.0, 1.0]], "covariance"),
        "the covariance of pi and phi is not 0 by 0",
    ),
    "1e308": ((1e308, "base", "covariance", 0, 0), "covariance[0][0]: found 1e+308"),
    "infinite": ((float("inf"), "base", "values", 0), "base.values[0]: found inf"),
    "negative deviation": ((-1.0, "base", "std", 0), "a deviation is not negative"),
    "one value less": (([1.0], "base", "values"), "not of one length"),
    "true for a number": ((True, "elapsed_s"), "elapsed_s: found True"),
    "a momentum": (
        ("known", "initial_momentum"),
        "initial_momentum: found 'known'; give 'unknown'",
    ),
    "what is not kept": (({"pi": 1}, "fits"), "fits: found {'pi': 1}"),
    "another version": (("orbident/result/1", "schema"), "give 'orbident/result/2'"),
}


@pytest.mark.parametrize(("edit", "words"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(edit: tuple[Any, ...], words: str):
    with pytest.raises(InputError) as caught:
        check(edited(*edit))
    line = str(caught.value)
    assert line.startswith("run/result.json: is not what 'orbident identify' wrote: ")
    assert words in line
    assert line.endswith("; identify again")
    # Paths and reasons, with what was found cut at 80 characters.
    assert len(line) < 300


def test_what_is_no_result_at_all():
    with pytest.raises(InputError, match=r"identify again$"):
        check({})


def test_every_place_with_every_kind_of_value():
    """Whatever stands anywhere: it is accepted or refused, and no other error."""

    def places(value: Any, at: tuple[str | int, ...] = ()) -> Any:
        yield at
        entries = value.items() if isinstance(value, dict) else ()
        entries = enumerate(value) if isinstance(value, list) else entries
        for key, entry in entries:
            yield from places(entry, (*at, key))

    random = np.random.default_rng(0)
    every = [at for at in places(WRITTEN) if at]
    values = [None, True, -1, 10**400, 1e308, "x", [], [1], {}, {"a": 1}]
    for k in random.choice(len(every), 150, replace=False):
        for value in values:
            try:
                check(edited(value, *every[k]))
            except InputError:
                continue
