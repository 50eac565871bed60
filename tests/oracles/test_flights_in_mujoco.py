"""Seventeen flights by MuJoCo, with something acting of which nothing is declared.

Each is identified: what acts is named and its size right, or it is too faint to be seen
and in all deviations. Or it is refused with its cause, and then identified as the cause
says: before and after an event. All of a draw take
some minutes; as tests, or as a table of any draw:

    .venv/bin/python -m pytest -m long tests/oracles/test_flights_in_mujoco.py
    PYTHONPATH=tests/support .venv/bin/python tests/oracles/test_flights_in_mujoco.py 1
"""

import re
import sys
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pytest
from acting_in_mujoco import Burst, Capture, Swell, Torque
from seventeen_flights import SPEED, Case, cases
from small_problems import at_rest

from orbident.environment.agents import STEADY
from orbident.environment.torques_and_forces import slow_shapes
from orbident.estimation.identify import identify
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.may_act import may_act

FAR = 4.0
"""Deviations."""

WRONG = 5.0
"""Deviations by which what is accepted must not be off."""

ASSUMED = "use --initial-momentum unknown"
"""What is advised where the momentum changes by much."""

SEEDS = 1000
"""The noise of a flight has this seed, and its robot's number more."""

QUICK, SLOWER = (8, 11, 12), (0, 4)
"""On a table a torque, film and tilt, which are soon identified; in space a torque that
turns with the base or does not, which CI flies."""

Verdict = Literal["identified", "held", "not held", "refused", "wrong"]
"""Held is what was not seen, and is among what may act all the same."""


@dataclass(frozen=True)
class Score:
    """What became of a flight."""

    case: Case
    verdict: Verdict
    far: float
    """The largest error of a base parameter in its deviations; of a refused flight, of
    the parts that its cause says to identify."""
    said: float
    """The same where the user says what acts, so that deviations are narrower."""
    wider: float
    """Deviations over those if nothing acted."""
    acting: str
    """What was found to act, with its deviations."""
    size: float
    """The largest error of its size in its deviations."""
    cause: str

    def row(self) -> str:
        """A row of the table."""
        robot = self.case.flight.robot
        where = "space" if robot.motion == "spatial" else "table"
        return (
            f"| {where}, {len(robot.joints)} joints, {len(robot.wheels)} wheels | "
            f"{self.case.name} | {self.verdict} | {self.far:.1f} | {self.said:.1f} | "
            f"{self.wider:.1f} | {self.acting} | {self.size:.1f} | {self.cause} |"
        )


HEAD = (
    "| robot | acts | verdict | base, sigmas | if said | wider | found | "
    "size, sigmas | cause |\n|---|---|---|---|---|---|---|---|---|"
)


def scored(case: Case) -> Score:
    """Identify a flight as a user does who knows of nothing."""
    recording = case.flight.recorded(SEEDS + case.number)
    result = identified(case, recording)
    if result.status == "rejected":
        return _refused(case, recording, result)
    far, acts = off(case, result), case.flight.acts
    # Bursts are looked for, and need not be said.
    names = () if isinstance(acts, Burst) else (acts.group,)
    robot = replace(case.known, disturbances=may_act(names))
    said = off(case, identified(case, recording, robot))
    named = acts.group in {fit.group for fit in result.disturbances.values()}
    held = {*result.allowed, *(STEADY.get(group) for group in result.allowed)}
    size = _size(case, result) if named else np.nan
    verdict: Verdict = "identified" if named else "not held"
    if not named and acts.group in held:
        verdict = "held"
    if np.nanmax([far, said, size]) > WRONG:
        verdict = "wrong"
    wider = result.widened_by
    return Score(case, verdict, far, said, wider, _acting(result), size, "")


def identified(
    case: Case,
    recording: Recording,
    robot: Robot | None = None,
    momentum: InitialMomentum | None = None,
) -> Result:
    return identify(
        robot or case.known,
        recording,
        initial_momentum=momentum or case.initial_momentum,
    )


def off(case: Case, result: Result, captured: bool = False) -> float:
    """The largest error of a base parameter, in its deviations; NaN if refused."""
    robot, acts = case.flight.robot, case.flight.acts
    theta = robot.theta
    if captured:
        assert isinstance(acts, Capture)
        theta = acts.onto(theta, robot.bodies)
    true = minimal_sets(result.robot).beta(theta)
    return float(np.abs((result.base.values - true) / result.base.std).max())


def _acting(result: Result) -> str:
    """The groups; with sizes where these are few."""
    fits = result.disturbances
    if len(fits) > 4:
        return ", ".join(sorted({fit.group for fit in fits.values()}))
    return ", ".join(
        f"{name} {fit.value:.3g} +- {fit.std:.1g}" for name, fit in fits.items()
    )


def _size(case: Case, result: Result) -> float:
    """The largest error of what acts, in its deviations.

    Of a slow torque its history is compared, as if its numbers' errors were
    independent: of their covariance a result has the deviations only.
    """
    acts, fits = case.flight.acts, result.disturbances
    if isinstance(acts, Burst):
        return _size_of_burst(case, acts, result)
    if not isinstance(acts, Swell):
        own = {name: fit for name, fit in fits.items() if fit.group == acts.group}
        return max(
            abs(fit.value - acts.sizes.get(name, 0.0)) / fit.std
            for name, fit in own.items()
        )
    t = np.linspace(0.0, case.flight.motion.duration, 200)
    shapes = slow_shapes(at_rest(case.known, t), acts.group)
    torque, variance = np.zeros((2, t.size, 3))
    slow = {acts.group, STEADY[acts.group]}
    for name, fit in fits.items():
        if fit.group in slow:
            _, axis, *shape = name.split(".")
            x = shapes[:, int(shape[0]) - 1] if shape else np.ones_like(t)
            torque[:, "xyz".index(axis)] += fit.value * x
            variance[:, "xyz".index(axis)] += np.square(fit.std * x)
    shown = variance > 0
    error = np.abs(torque - acts.at(t))[shown]
    return float(np.max(error / np.sqrt(variance[shown])))


def _size_of_burst(case: Case, burst: Burst, result: Result) -> float:
    """The error of by how much the CM is faster after it, in its deviations."""
    own = [result.disturbances.get(f"push.moving.{axis}.0") for axis in "xyz"]
    found = np.array([fit.value for fit in own if fit])
    std = np.array([fit.std for fit in own if fit])
    speed = float(np.linalg.norm(found))
    true = float(np.linalg.norm(burst.force)) * burst.seconds / case.flight.robot.mass
    return abs(speed - true) / float(np.linalg.norm(found * std / speed))


def _refused(case: Case, recording: Recording, result: Result) -> Score:
    """Go on as the cause says: identify what comes before and after an event."""
    cause, acts = result.with_causes().warnings[0], case.flight.acts
    if ASSUMED in cause:
        result = identified(case, recording, momentum="unknown")
        cause = result.with_causes().warnings[0]
    found = re.search(r"between t = (\S+) and (\S+) s", cause)
    far = np.nan
    if found and isinstance(acts, Burst | Capture):
        begin, end = map(float, found.groups())
        before = _part(recording, recording.t < begin, "before")
        after = _part(recording, recording.t > end, "after")
        if isinstance(acts, Capture):
            one = identified(case, before)
            other = identified(case, after, momentum="unknown")
            far = max(off(case, one), off(case, other, captured=True))
        elif case.initial_momentum == "unknown":
            both = identify(case.known, [before, after])
            far = off(case, both)
        else:
            far = off(case, identified(case, before))
    verdict: Verdict = "wrong" if far > WRONG else "refused"
    return Score(case, verdict, far, far, np.nan, "", np.nan, cause)


def _part(recording: Recording, rows: np.ndarray, name: str) -> Recording:
    columns = {key: column[rows] for key, column in recording.columns.items()}
    return Recording(recording.t[rows], columns, source=name)


def marked(k: int) -> pytest.MarkDecorator:
    return pytest.mark.slow if k in SLOWER else pytest.mark.long


@pytest.mark.parametrize(
    "k",
    [k if k in QUICK else pytest.param(k, marks=marked(k)) for k in range(17)],
)
def test_a_flight_ends_well(k: int):
    """What acts is identified with the robot, or is in its deviations; of a capture the
    time is named, and both robots are identified, before and after it."""
    case = cases(0)[k]
    score, acts = scored(case), case.flight.acts
    assert score.far < FAR, score.row()
    assert score.said < FAR, score.row()
    if isinstance(acts, Capture):
        assert "the robot changed" in score.cause
        found = re.search(r"between t = (\S+) and (\S+) s", score.cause)
        assert found
        begin, end = map(float, found.groups())
        assert begin < acts.at < end
    else:
        assert score.verdict in {"identified", "held"}, score.row()
        assert not score.size > FAR, score.row()


@pytest.mark.slow
def test_a_torque_may_give_more_momentum_than_the_wheels_have():
    """The linear fits know of no torque, and see nothing that answers the wheels: four
    times their momentum comes from outside."""
    case = cases(7)[1]
    wheel, *others = case.flight.robot.wheels
    assert not others
    acts = case.flight.acts
    assert isinstance(acts, Torque)
    given = np.linalg.norm(acts.vector) * case.flight.motion.duration
    assert given > 4 * wheel.inertia * SPEED
    score = scored(case)
    assert score.verdict == "identified", score.row()


if __name__ == "__main__":
    print(HEAD)
    for each in cases(int(sys.argv[1])):
        print(scored(each).row(), flush=True)
