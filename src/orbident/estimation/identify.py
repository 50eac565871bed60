"""The main job: from a robot and a recording to every free-flying parameter."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

from orbident.errors import InputError
from orbident.estimation.causes.causes import causes
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Estimator
from orbident.estimation.estimators import IN_STRETCHES, Method, estimator_of
from orbident.estimation.linear_fits import INITIAL_MOMENTA, InitialMomentum
from orbident.estimation.mass_routes import BURN, is_a_mass
from orbident.estimation.quantities import Quantity
from orbident.estimation.result import Result
from orbident.estimation.results import result_of
from orbident.estimation.solve import solve
from orbident.estimation.weigh import Weighing, weigh
from orbident.recordings.long_recording import LARGE, LongRecording
from orbident.recordings.recording import Recording
from orbident.recordings.tables import open_recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.threads import one_blas_thread


@one_blas_thread
def identify(
    robot: Robot | str | Path,
    recording: Recording | LongRecording | str | Path,
    method: Method | Estimator = "maximum-likelihood",
    initial_momentum: InitialMomentum = "unknown",
    burn: Recording | None = None,
    progress: Callable[[float], object] = lambda _: None,
) -> Result:
    """Identify `pi` (Eq. 24), `phi` (Eq. 31) and the total mass (Eq. 32).

    Args:
        robot: geometry, wheels and structure, or the name of its file; its nominal
            inertia is at most where a search starts.
        recording: of the free-floating robot, or the name of its file. A long one is
            read in stretches where the method allows it.
        method: an estimator, or the name of one with its usual options:
            `"maximum-likelihood"` fits all sensors at once; `"structured"` the
            equations 24 and 31, for what `pi` and `phi` are made of; `"least-squares"`
            is the paper's: `pi` and `phi` each for itself, with deviations that know
            white noise only, no bias and no drift; `"recursive"` goes sample by sample,
            from CAD values that are 30 % uncertain, and watches for changes of the
            robot.
        initial_momentum: `"unknown"` estimates the momentum with `pi`; `"at-rest"`
            takes it from the wheels of a base at rest, or as zero where everything
            was at rest before the wheels spun up; `"first-sample"` subtracts the
            first sample (Eq. 24).
        burn: of the same robot, joints locked, by a known thrust: the mass that it
            tells (Eq. 40) is put beside the others. What `weigh` needs.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: a file cannot be read, a column is missing, there are too few
            samples, the nominal mass matrix is singular, the burn cannot be weighed,
            or an argument is not one of those named.
    """
    started = time.perf_counter()
    robot = robot if isinstance(robot, Robot) else load_robot(robot)
    if isinstance(recording, str | Path):
        recording = open_recording(Path(recording))
    estimator = estimator_of(method)
    recording = _in_stretches(recording, estimator)
    _check_momentum(initial_momentum)
    weighing = None if burn is None else weigh(robot, burn)
    solved = solve(robot, recording, initial_momentum, estimator, progress)
    masses = _masses(weighing, solved.estimate)
    judgement = judge(solved, masses)
    elapsed = time.perf_counter() - started
    result = result_of(
        solved.problem,
        estimator.name,
        solved.estimate,
        judgement,
        masses,
        weighing,
        elapsed,
    )
    if result.status == "ok":
        return result
    # They are searched for after this verb has returned, and its limit with it.
    return replace(result, causes=one_blas_thread(lambda: tuple(causes(solved))))


def _in_stretches(
    recording: Recording | LongRecording, estimator: Estimator
) -> Recording | LongRecording:
    """A long recording as the estimator can take it."""
    long = isinstance(recording, LongRecording)
    if not isinstance(estimator, IN_STRETCHES):
        return recording.read() if long else recording
    if long or recording.t.size < LARGE:
        return recording
    return LongRecording.of(recording)


def _masses(weighing: Weighing | None, estimate: Estimate) -> dict[str, Quantity]:
    """By every route that gives one, the method's own last."""
    masses = dict(estimate.masses)
    if weighing is not None and weighing.status == "ok":
        masses = {BURN: weighing.mass, **masses}
    *others, own = masses.items()
    M = estimate.mass
    kept = [(name, at) for name, at in others if is_a_mass(at.value, at.std, M)]
    return dict([*kept, own])


def _check_momentum(given: str) -> None:
    if given not in get_args(InitialMomentum):
        choices = " or ".join(INITIAL_MOMENTA)
        raise InputError(f"initial momentum '{given}' is unknown; use {choices}")
