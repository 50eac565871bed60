"""What laboratories do wrong with columns of thrusters, from one end to the other.

Each of four mistakes is made with as many flights as ORBIDENT_MISTAKES says (6 by
default), every other one with a dead valve; `-s` shows the refusals and their CPU time:

    ORBIDENT_MISTAKES=6 pytest -m long -s tests/statistics/test_valve_mistakes.py
"""

import os
import re
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from valved_satellite import Truth, flown, satellite, with_dead

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

SEEDS = int(os.environ.get("ORBIDENT_MISTAKES", "6"))

KNOWN = "known: {mass: 23.09 +- 0.01 kg}\n"

NAMES = [f"thruster.t{k}.duty" for k in range(1, 9)]

Made = tuple[Robot, Recording, str]
"""With a mistake, and how what is said of it is to begin."""


def changed(seen: Recording, by: Callable[[np.ndarray], np.ndarray]) -> Recording:
    """The recording with other columns of duty."""
    table = by(np.column_stack([seen.column(name) for name in NAMES]))
    return seen.with_columns(dict(zip(NAMES, table.T, strict=True)))


def another_corner(robot: Robot, seen: Recording, _: np.random.Generator) -> Made:
    other = changed(seen, lambda on: np.roll(on, 2, axis=1))
    words = "thrusters are numbered from another corner: what is recorded as t1 is t7"
    return robot, other, words


def reversed_directions(robot: Robot, seen: Recording, _: np.random.Generator) -> Made:
    gas = tuple(replace(each, direction=-each.direction) for each in robot.thrusters)
    return replace(robot, thrusters=gas), seen, "thrusters push the other way"


def percent(robot: Robot, seen: Recording, _: np.random.Generator) -> Made:
    return robot, changed(seen, lambda on: 100 * on), ".*if it is in percent"


def another_zero(robot: Robot, seen: Recording, random: np.random.Generator) -> Made:
    """From one to eight seconds, either way; valves are 0.14 s late on average."""
    rows = int(random.choice([-1, 1]) * random.integers(16, 129))

    def moved(on: np.ndarray) -> np.ndarray:
        on = np.roll(on, rows, axis=0)
        on[slice(rows, None) if rows < 0 else slice(rows)] = 0.0
        return on

    way = "before" if rows > 0 else "after"
    return robot, changed(seen, moved), rf"the commands of thrusters act \S+ s {way}"


@pytest.mark.long
@pytest.mark.parametrize("known", ["", KNOWN])
def test_mistakes_are_named(tmp_path, known):
    robot = satellite(tmp_path, more=known)
    named = made = 0
    for mistake in (another_corner, reversed_directions, percent, another_zero):
        for seed in range(SEEDS):
            random = np.random.default_rng(3000 + seed)
            truth = Truth(
                gains=0.1 * random.standard_normal(8),
                coupling=0.02,
                tilt=tuple(1e-3 * random.standard_normal(2)),
            )
            truth = with_dead(truth, 1 + seed % 8) if seed % 2 else truth
            said_to_be, seen, words = mistake(robot, flown(truth, seed), random)
            start = time.process_time()
            said = refusal(said_to_be, seen)
            spent = time.process_time() - start
            right = bool(re.match(words, said))
            made, named = made + 1, named + right
            print(f"{mistake.__name__} {seed}: {spent:.1f} s, {right}: {said}")
    print(f"mass known: {bool(known)}; {named} of {made} named")
    assert named >= made * 23 / 24


def refusal(robot: Robot, seen: Recording) -> str:
    """What is said of it; nothing where it is not refused."""
    try:
        result = identify(robot, seen)
    except InputError as error:
        return str(error)
    if result.status != "rejected":
        return ""
    causes = [c.reason for c in result.with_causes().checks if c.name == "cause"]
    return "; ".join(causes)
