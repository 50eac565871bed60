"""A recording that nothing brings to a fit: the search for its cause has an end."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from cause_problems import clean, fitted, problem_with

from orbident.diagnosis import causes as module
from orbident.diagnosis.causes import LOST, _tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.allowance import Allowance
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error import least_cost
from orbident.estimation.output_error.estimator import OutputError
from orbident.recordings.recording import Recording

STAGES = "noisier_sensors", "spikes", "missing_wheel", "lasting_errors"


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    return problem_with()


@pytest.fixture(scope="module")
def lost(problem: MomentumProblem) -> Estimate:
    return replace(fitted(problem), converged=False)


@pytest.mark.parametrize("fits", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_so_many_trials_without_a_least_cost_are_enough(
    problem, lost, monkeypatch, fits
):
    """Those that were not even fitted do not count."""
    made: list[Trial] = []

    def trials(problem: MomentumProblem, *_: object, **__: object) -> Iterator[Trial]:
        for _k in range(4):
            made.append(Trial("", False, 1e9, lost if fits else None))
            yield made[-1]

    for stage in STAGES:
        monkeypatch.setattr(module, stage, trials)
    _tried(Solved(problem, [], lost, None), [], 0.0, Allowance())
    assert len(made) == (LOST if fits else 4 * len(STAGES))


@pytest.mark.parametrize(("tested", "expected"), [(False, 1), (True, 3)])
def test_nonsense_does_not_ask_what_else_acts(monkeypatch, tested: bool, expected: int):
    """Joints that show another motion: no search more for every group.

    What is only tried is searched for once. A part of a recording may be good, and is
    searched for loosely, too, and from there.
    """
    recording = clean().recording.between(0.0, 6.0)
    columns = {
        name: x[::-1] if name.startswith("joint") else x
        for name, x in recording.columns.items()
    }
    part = problem_with().amended(recording=Recording(recording.t, columns))
    searches = 0

    def counted(*given, **named):
        nonlocal searches
        searches += 1
        return solved(*given, **named)

    solved = least_cost.solved
    monkeypatch.setattr(least_cost, "solved", counted)
    OutputError(steps=12, tested=tested).estimate(part, lambda _: None)
    assert searches == expected
