"""Maximum likelihood by output error (theory: Section 6).

Momentum conservation predicts what all sensors show; the unknowns are those that make
the whitened prediction errors smallest: `beta = [M, sigma, iota]`, momentum and CM
motion, sensor biases, attitudes where segments of the recording meet (multiple
shooting), and the errors of the smoothed joint histories. The information at the
solution gives the covariance.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.environment.agents import FREE, NOISE, SLOW
from orbident.estimation.base_parameters import (
    beta_of_fits,
    prior_std,
)
from orbident.estimation.estimate import (
    Estimate,
    Progress,
    estimate_of_beta,
)
from orbident.estimation.levels import ChiSquare
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.beforehand import (
    check_disturbances_show,
    first_momentum,
    prior_of,
    shared_of,
    with_hidden_held,
    with_others,
)
from orbident.estimation.output_error.covariance_parts import (
    covariance_parts,
    estimate_of,
)
from orbident.estimation.output_error.disturbance_sizes import (
    identified,
    surprise_of_known,
    surprise_of_rest,
    widened_by,
    with_densities,
)
from orbident.estimation.output_error.hypotheses import (
    WorldFit,
    fit_as_expected,
    fit_in_world,
)
from orbident.estimation.output_error.joint_laws import (
    ENOUGH,
    LOOSE,
    elsewhere,
    springs_of,
    what_is_carried_held,
)
from orbident.estimation.output_error.least_cost import FEW_STEPS, Search
from orbident.estimation.output_error.looseness import LOOSE_TURNS
from orbident.estimation.output_error.noise_scaling import (
    Fitted,
    fit_of_sensor,
    goodness_of,
    sensor_signals,
)
from orbident.estimation.output_error.problem import (
    Problem,
    linear,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensors import TORQUES, Sensors, sensors_of
from orbident.estimation.output_error.solver import STEPS, solved
from orbident.estimation.output_error.taken_for_zero import sensitivity
from orbident.estimation.output_error.torques import drives_of, joints_driven
from orbident.estimation.output_error.walking_rates import Density, walked
from orbident.estimation.output_error.wheel_speeds import has_read_speeds, likely_speeds
from orbident.estimation.solution import OUTSIDE, Shared, Solution, Unknowns
from orbident.estimation.unknowns import CalibrationFit
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.delays import delays
from orbident.preprocessing.followers import without_followers
from orbident.preprocessing.rates import gaps_as_rows
from orbident.preprocessing.samples import OutsideMomentum
from orbident.recordings.long_recording import LARGE
from orbident.robot.description import Robot

CLOCK_STD = 0.1
"""s: standard deviation beforehand of a clock that was corrected."""

SETTLED = 0.1
"""Deviations: parameters that change by less have settled."""

ROUNDS = 10
"""Times that wheels' speeds are put right, at most: each halves the error left."""


@dataclass(frozen=True)
class OutputError:
    """Maximum likelihood of all that the sensors showed, by output error."""

    name: str = "maximum-likelihood"
    steps: int = STEPS
    """The most steps that the search takes with one set of the sensors' weights; where
    fewer than usual find no least cost, and the fit is bad, it is not asked what else
    acts."""
    tested: bool = True
    """Whether it is asked if something acts more than it may."""
    others: Shared | None = None
    """What other recordings of the same robot say; the search starts there."""
    free: Mapping[str, float] = field(default_factory=dict)
    """Standard deviations beforehand of errors of instruments, by family or by name, in
    place of the tolerances of the robot file; SI."""

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Fit all sensors at once."""
        done = 0.0

        def step() -> None:
            # How many steps there will be nobody knows: half of what is left.
            nonlocal done
            done += (1 - done) / 2
            progress(done)

        recording = gaps_as_rows(problem.recording)
        if recording is not problem.recording:
            problem = problem.amended(recording=recording)
        robot = problem.robot
        late = delays(robot, recording, problem.late)
        heard = without_followers(recording, problem.samples.led)
        sensors = sensors_of(robot, heard, late, problem.samples.speeds)
        search = self._search(problem, sensors, step)
        # Without declared noise, what splines leave between samples looks slow too.
        excluded = () if search.declared == {*sensors.by_name} else SLOW
        check_disturbances_show(search.problem)
        equations, densities = with_densities(
            search.problem,
            lambda equations: replace(search, problem=equations).freed(),
        )
        # Densities that nobody declared are estimated from all waves.
        equations = equations._replace(shows=search.shows)
        fit = fit_as_expected(replace(search, problem=equations))
        fit, sensors = _with_likely_speeds(problem, sensors, fit)
        made = partial(_estimate, problem, sensors, densities)

        def in_world() -> Estimate:
            found = made(fit_in_world(fit, excluded))
            other = partial(made, fit) if found.unexpected else None
            return replace(found, expected=other)

        if self.tested and not _elsewhere(fit.search.problem, fit.found.solution):
            return in_world()
        return replace(made(fit), tested=in_world)

    def _search(
        self, problem: MomentumProblem, sensors: Sensors, step: Callable[[], object]
    ) -> Search:
        """The equations, and where their least cost is looked for."""
        robot, sets, samples = problem.robot, problem.sets, problem.samples
        momentum = problem.initial_momentum
        # A clock that was corrected is known no better than it was found.
        late = problem.clocks.get("joints")
        free = {"joints.clock": CLOCK_STD} if late and late.believed else {}
        following = partial(
            problem_of, robot, sets, samples, sensors, {**free, **self.free}
        )
        equations = following()
        outside = first_momentum(robot, sets, samples, problem.fits, momentum)
        prior = prior_of(robot, sets, equations.declared, outside, problem.rest_std)
        beta = _first(problem)
        if self.others is not None:
            beta = self.others.beta
            prior = with_others(prior, self.others, equations.declared)
        if not samples.tracked:
            prior = with_hidden_held(prior, robot, sets)
        by_cad, steps = sets.beta(robot.theta), self.steps
        # Linear fits are poor where a velocity is noisier than the motion. Momentum
        # alone is that of several robots, of which the true one is near to CAD.
        by_fits = beta[0] > 0 and not np.array_equal(beta, by_cad) and samples.tracked
        starts = [
            walked(equations, start_of(equations, samples, outside, at))
            for at in ([beta, by_cad] if by_fits else [by_cad])
        ]
        if robot.passive:
            parts = [following(unexplained) for unexplained in LOOSE]
            ends = [
                start_of(parts[0], samples, outside, beta)._replace(common=each.common)
                for each in starts
            ]
            held = what_is_carried_held(prior)
            for part in parts:
                fits = [
                    solved(
                        part, part.weights, held, end, step, self.steps, enough=ENOUGH
                    )
                    for end in ends
                ]
                best = min(fits, key=lambda fit: fit.cost)
                ends = [best.state]
                # Where joints do not swing as declared, a fit of them ends nowhere.
                if _elsewhere(part, best):
                    steps = min(steps, FEW_STEPS)
                    break
            starts = [ends[0].at(np.isin(parts[0].boundaries, equations.boundaries))]
        nominal = starts[-1]
        loosely = [partial(following, turning=each) for each in LOOSE_TURNS]
        at_hand, shows = [], dict[str, float]()
        # Those of many samples are as good as they will be, and equations take long.
        if equations.t.size >= LARGE:
            _core.give_back_memory()
        else:
            acting = equations.expected
            places = np.array([each.place for each in (*equations.declared, *acting)])
            every = [
                linear(equations, equations.weights, at.carried(places))
                for at in starts
            ]
            order = sorted(range(len(every)), key=lambda k: every[k].cost)
            starts, at_hand = [starts[k] for k in order], [every[order[0]]]
            del every
            sizes = np.linalg.norm(at_hand[0].factor[:, -1 - len(acting) : -1], axis=0)
            shows = {each.name: size for each, size in zip(acting, sizes, strict=True)}
        return Search(
            equations,
            prior,
            starts[0],
            nominal,
            at_hand,
            loosely if self.tested or self.steps == STEPS else [],
            shows,
            {name: each.least / each.std for name, each in sensors.by_name.items()},
            {name for name, each in sensors.by_name.items() if each.declared},
            step,
            steps,
        )


def _with_likely_speeds(
    problem: MomentumProblem, sensors: Sensors, fit: WorldFit
) -> tuple[WorldFit, Sensors]:
    """The fit to the speeds that gyro and tachometers show together, if any was read.

    Args:
        problem: of a recording.
        sensors: what they showed.
        fit: to the speeds as they were read.

    Returns:
        The fit, and what sensors would have shown with its speeds.
    """
    shown, read = sensors, has_read_speeds(problem.samples, sensors)
    for _ in range(ROUNDS if read else 0):
        solution = fit.found.solution
        if not solution.converged:
            break
        own = fit.search.problem
        samples, shown = likely_speeds(problem, sensors, own, fit.found)
        there = problem_of(problem.robot, problem.sets, samples, shown, like=own)
        equations = own._replace(recorded=there.recorded, samples=there.samples)
        search = replace(
            fit.search, problem=equations, start=solution.state, at_hand=[]
        )
        fit = fit_as_expected(search)
        if _change(solution, fit.found.solution) < SETTLED:
            break
    return fit, shown


def _change(before: Solution, after: Solution) -> float:
    """The largest change of a parameter, in its deviations."""
    first, changed = after.linear.local + OUTSIDE, after.state.beta - before.state.beta
    variances = np.diag(after.covariance)[first : first + changed.size]
    return float(np.max(np.abs(changed) / np.sqrt(variances)))


def _elsewhere(problem: Problem, solution: Solution) -> bool:
    """Whether a joint does not swing as declared: then no test means anything."""
    robot = problem.acting.followed.robot
    springs = springs_of(robot, _calibration(problem, solution))
    return bool(elsewhere(robot.passive, springs))


def _estimate(
    problem: MomentumProblem,
    sensors: Sensors,
    densities: Mapping[str, Density],
    fit: WorldFit,
) -> Estimate:
    """What a fit says."""
    robot, sets = problem.robot, problem.sets
    found, equations = fit.found, fit.search.problem
    sources = partial(covariance_parts, equations, found.solution)
    found = found._replace(solution=fit.zeros.noise.weakened)
    beta = estimate_of(found.solution, prior_std(robot, sets))
    by_sensor = {name: fit_of_sensor(sensors, found, name) for name in found.parts}
    calibration = _calibration(equations, found.solution)
    disturbances = identified(equations, found.solution, densities, fit.freed)
    return replace(
        estimate_of_beta(
            problem,
            beta,
            "maximum likelihood",
            {name: fit.rms for name, fit in by_sensor.items()},
            goodness_of(sensors, found),
            disturbed=bool(disturbances) or bool(_driven(robot, equations)),
        ),
        sensors=by_sensor,
        biases=_biases(sets, sensors, found),
        disturbances=disturbances,
        allowed=_allowed(equations),
        widened_by=widened_by(equations.expected, found.solution),
        unexpected=fit.freed,
        rest=surprise_of_rest(equations, found.solution)
        if problem.initial_momentum == "at-rest"
        else ChiSquare(0.0, 0),
        carried=surprise_of_known(found.solution, "carried"),
        weighed=surprise_of_known(found.solution, "measured"),
        calibration=calibration,
        springs=springs_of(robot, calibration),
        drives=drives_of(robot, calibration, _driven(robot, equations)),
        sensitivity=partial(sensitivity, fit.zeros),
        sources=sources,
        converged=found.solution.converged,
        settled=found.settled,
        convergence=found.convergence,
        signals=sensor_signals(robot, equations, sensors, found),
        solution=fit.expected.solution,
        shared=partial(shared_of, equations, found.solution),
        given=partial(_given, equations, found.solution.state),
    )


def _driven(robot: Robot, equations: Problem) -> tuple[str, ...]:
    """The columns of torques that count."""
    if TORQUES not in equations.weights:
        return ()
    return joints_driven(robot, equations.weights[TORQUES])


def _first(problem: MomentumProblem) -> Float[np.ndarray, " beta"]:
    """A first `beta` by the linear fits; or by CAD, where these know too little.

    Thrust and what swings make them bodies that cannot exist. So it is where torques
    alone say how large the robot is.
    """
    robot = problem.robot
    if not (problem.linear and problem.scale_seen):
        return problem.sets.beta(robot.theta)
    return beta_of_fits(robot, problem.sets, problem.fits).values


def _allowed(problem: Problem) -> dict[str, float]:
    """How large what acts may be, by group; NaN for anything."""
    here = {each.family for each in problem.acting.expected}
    return {
        group: each.size if np.isfinite(each.size) else np.nan
        for group, each in problem.acting.allowed.items()
        if group in here and group != NOISE
    }


def _biases(
    sets: MinimalSets, sensors: Sensors, found: Fitted
) -> dict[str, dict[str, float]]:
    """The biases at the end of the recording, estimated from all of it."""
    turning, moving = sets.regressors.momentum_axes, sets.regressors.velocity_axes
    solution = found.solution
    C = solution.end.covariance(solution.covariance)
    biases = {}
    for first, name, axes in ((3, "gyro", turning), (6, "accelerometer", moving)):
        for k in axes if name in sensors.by_name else ():
            biases[f"{name}.{'xyz'[k]}"] = {
                "value": float(solution.state.local[-1, first + k]),
                "std": float(np.sqrt(max(C[first + k, first + k], 0.0))),
            }
    return biases


def _given(problem: Problem, at: Unknowns) -> OutsideMomentum | None:
    return problem.acting.given(at.beta, at.calibration, at.selected)


def _calibration(problem: Problem, solution: Solution) -> dict[str, CalibrationFit]:
    values, n = solution.state.calibration, len(solution.state.selected)
    std = np.sqrt(np.diag(solution.covariance))[-n:] if n else np.zeros(0)
    # Disturbances come after them.
    return {
        each.name: CalibrationFit(
            float(value), float(deviation), np.nan if each.std == FREE else each.std
        )
        for each, value, deviation in zip(problem.declared, values, std, strict=False)
    }
