"""The main job: from a robot and a recording to every free-flying parameter.

Methods have names here: a new one is a file, and a word in this one.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

from orbident.choices import InitialMomentum, Method
from orbident.errors import InputError
from orbident.estimation.allowance import Allowance, limited_to
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Estimator, Progress, Solved
from orbident.estimation.least_squares import LeastSquares, Structured
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.sensors import joints_with_torques
from orbident.estimation.parameter_checks import BURN, is_a_mass
from orbident.estimation.pushes import with_push
from orbident.estimation.quantities import Quantity
from orbident.estimation.recursive.history import Recursive
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.estimation.several import (
    agreement,
    as_one,
    check_different,
    labels_of,
    solved_together,
)
from orbident.estimation.solve import solve
from orbident.estimation.weigh import Weighing, weigh
from orbident.recordings.long_recording import LARGE, LongRecording
from orbident.recordings.recording import Recording
from orbident.recordings.tables import RecordingLike, recording_of
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured
from orbident.robot.robot_file import load_robot
from orbident.threads import one_blas_thread

METHODS: tuple[Method, ...] = get_args(Method)

ESTIMATORS: dict[str, type[Estimator]] = {
    "maximum-likelihood": OutputError,
    "structured": Structured,
    "least-squares": LeastSquares,
    "recursive": Recursive,
}

IN_STRETCHES = (LeastSquares, Structured)
"""Those that take a long recording in stretches."""


def estimator_of(method: str | Estimator) -> Estimator:
    """An estimator by its name, or as it is.

    Raises:
        InputError: there is none of that name.
    """
    if not isinstance(method, str):
        return method
    if method not in ESTIMATORS:
        raise InputError(f"method '{method}' is unknown; use {' or '.join(METHODS)}")
    return ESTIMATORS[method]()


Opened = Recording | LongRecording


@one_blas_thread
def identify(
    robot: Robot | str | Path | Mapping[str, Any],
    recording: RecordingLike | Sequence[RecordingLike],
    method: Method | Estimator = "maximum-likelihood",
    initial_momentum: InitialMomentum = "unknown",
    burn: Recording | None = None,
    progress: Progress = lambda _: None,
) -> Result:
    """Identify `pi` (Eq. 24), `phi` (Eq. 31) and the total mass (Eq. 32).

    Args:
        robot: geometry, wheels and structure, or what `load_robot` takes; its nominal
            inertia is at most where a search starts.
        recording: of the free-floating robot, the name of its file, or its columns by
            name (a `pandas.DataFrame`, or as `Recording.of` takes). A long one is read
            in stretches where the method allows it. Several are identified as one by
            maximum likelihood: each has its own momentum, attitudes, biases, clocks and
            disturbances.
        method: an estimator, or the name of one with its usual options:
            `"maximum-likelihood"` fits all sensors at once; `"structured"` the
            equations 24 and 31, for what `pi` and `phi` are made of; `"least-squares"`
            is the paper's: it estimates `pi` and `phi` separately, and its standard
            deviations count white noise but neither biases nor drifts;
            `"recursive"` goes sample by sample, from CAD values that are 30 %
            uncertain, and watches for changes of the robot.
        initial_momentum: `"unknown"` estimates the momentum with `pi`; `"at-rest"`
            takes it from the wheels of a base at rest, or as zero where everything
            was at rest before the wheels spun up; `"first-sample"` subtracts the
            first sample (Eq. 24).
        burn: of the same robot, joints locked, by a known thrust, as `weigh` needs it:
            its mass (Eq. 40) is compared with the others.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: a file cannot be read, a column is missing, there are too few
            samples, the nominal mass matrix is singular, the burn cannot be weighed,
            or an argument is not one of those named.
    """
    started = time.perf_counter()
    robot = robot if isinstance(robot, Robot) else load_robot(robot)
    estimator = estimator_of(method)
    if not isinstance(estimator, OutputError):
        instead = "use --method maximum-likelihood"
        require_measured(robot, f"method {estimator.name}", instead)
    recordings = _recordings(robot, recording, estimator)
    _check_momentum(initial_momentum)
    weighing = None if burn is None else weigh(robot, burn)

    def judged(solved: Solved) -> Result:
        elapsed = time.perf_counter() - started
        return _judged(solved, estimator, weighing, elapsed)

    if len(recordings) == 1:
        one = _solved(robot, recordings[0], initial_momentum, estimator, progress)
        return judged(one)
    if not isinstance(estimator, OutputError):
        raise InputError(
            f"several recordings are identified as one by maximum likelihood only, not "
            f"by {estimator.name}; give one recording, or use --method "
            "maximum-likelihood"
        )
    held = [
        each.read() if isinstance(each, LongRecording) else each for each in recordings
    ]
    check_different(held)
    labels = labels_of(held)
    alone = list[Solved]()
    for k, each in enumerate(held):
        part = _part(progress, k, len(held))
        alone.append(_solved(robot, each, initial_momentum, estimator, part))
    # The last one's result is that of all, and shows what any of them shows.
    order = sorted(range(len(held)), key=lambda k: alone[k].problem.samples.tracked)
    labels, alone = [labels[k] for k in order], [alone[k] for k in order]
    results = [judged(each) for each in alone]
    agree = agreement(alone, labels)
    if agree.passed and all(one.status == "ok" for one in results):
        again = solved_together(alone, estimator, lambda done: progress((1 + done) / 2))
        results = [judged(each) for each in again]
    return as_one(results, labels, agree)


def _solved(
    robot: Robot,
    recording: Opened,
    initial_momentum: InitialMomentum,
    estimator: Estimator,
    progress: Progress,
) -> Solved:
    """What one recording says, and the work that it took."""
    with limited_to(Allowance()) as allowance:
        solved = solve(robot, recording, initial_momentum, estimator, progress)
        solved = with_push(solved, estimator, progress)
    return solved._replace(work=allowance.spent)


def _part(progress: Progress, k: int, recordings: int) -> Progress:
    """Progress while one of several recordings is identified by itself.

    That is the first half of the work, shared evenly among them.
    """
    return lambda done: progress((k + done) / recordings / 2)


def _recordings(
    robot: Robot,
    given: RecordingLike | Sequence[RecordingLike],
    estimator: Estimator,
) -> list[Opened]:
    several = (
        [given] if isinstance(given, str) or not isinstance(given, Sequence) else given
    )
    if not several:
        raise InputError("no recording is given; name at least one")
    return [_in_stretches(robot, recording_of(each), estimator) for each in several]


def _judged(
    solved: Solved, estimator: Estimator, weighing: Weighing | None, elapsed_s: float
) -> Result:
    masses = _masses(weighing, solved.estimate)
    judgement = judge(solved, masses)
    result = result_of(
        solved.problem,
        estimator.name,
        solved.estimate,
        judgement,
        masses,
        weighing,
        elapsed_s,
    )
    if result.status == "ok":
        return result
    return replace(result, solved=solved)


def _in_stretches(robot: Robot, recording: Opened, estimator: Estimator) -> Opened:
    """A long recording as the estimator can take it.

    Torques are followed from the first sample to the last.
    """
    long = isinstance(recording, LongRecording)
    in_stretches = isinstance(estimator, IN_STRETCHES)
    if isinstance(estimator, Structured):
        seen = recording.digest if long else recording
        in_stretches = not joints_with_torques(robot, seen.with_joints_of(robot))
    if not in_stretches:
        return recording.read() if long else recording
    if long or recording.t.size < LARGE:
        return recording
    return LongRecording.of(recording)


def _masses(weighing: Weighing | None, estimate: Estimate) -> dict[str, Quantity]:
    """The mass by every route that gives one, the method's own last."""
    masses = dict(estimate.masses)
    if weighing is not None and weighing.status == "ok":
        masses = {BURN: weighing.mass, **masses}
    *others, own = masses.items()
    M = estimate.mass
    kept = [(name, at) for name, at in others if is_a_mass(at.value, at.std, M)]
    return dict([*kept, own])


def _check_momentum(given: str) -> None:
    if given not in get_args(InitialMomentum):
        choices = " or ".join(get_args(InitialMomentum))
        raise InputError(f"initial momentum '{given}' is unknown; use {choices}")
