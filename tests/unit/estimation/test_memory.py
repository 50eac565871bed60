"""Least squares of a long recording: samples are not copied."""

import tracemalloc
from collections.abc import Callable
from typing import Any

import pytest
from random_motions import random_motion

import orbident as oi
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import fit
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.obstacles import obstacles
from orbident.preprocessing.extent import Extent, motion_of
from orbident.preprocessing.samples import samples_of
from orbident.preprocessing.screening import screened

SAMPLES = 30_000

FIXED = 7e6
"""Bytes that no recording changes: blocks of 16,384 samples, and batches."""

A_SAMPLE = 24
"""Bytes: three columns at once. A copy of all would be more than two hundred."""


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    robot = oi.load_robot("paper-spatial")
    motion = random_motion(robot)
    recording = oi.simulate(robot, motion, rate=(SAMPLES - 1) / motion.duration)
    return momentum_problem(robot, recording, "unknown", lambda _: None)


def judged(problem: MomentumProblem) -> None:
    estimate = LeastSquares().estimate(problem, lambda _: None)
    solved = Solved(problem, obstacles(problem), estimate, None)
    found = judge(solved, dict(estimate.masses))
    assert "kinetic energy" in {check.name for check in found.checks}


# What looks at a stretch of samples for the clocks needs the same for any recording.
STAGES: dict[str, Callable[[MomentumProblem], Any]] = {
    "screening": lambda given: screened(given.robot, given.recording),
    "samples": lambda given: samples_of(given.robot, given.recording),
    "fit": lambda given: fit(
        given.robot, given.sets, given.samples, "unknown", lambda _: None
    ),
    "checks": judged,
    "result": lambda given: motion_of(given.robot, Extent.of(given.samples), ()),
}


@pytest.mark.parametrize("stage", STAGES)
def test_memory_grows_with_a_few_columns_only(problem, stage):
    tracemalloc.start()
    STAGES[stage](problem)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < FIXED + A_SAMPLE * SAMPLES
