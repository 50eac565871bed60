"""Exciting trajectories: time to quality, against the paper and against differences."""

import resource
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from orbident.estimation.identify import identify
from orbident.excitation.conditions import conditions_for
from orbident.excitation.design import LIMIT_STEPS, design_excitation
from orbident.excitation.design_problem import problem_for
from orbident.excitation.joint_limits import inner_point, polytope_of
from orbident.excitation.search import Effort, JointSearch, SearchSpace
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.spatial import paper_case
from orbident.trajectories.trajectory_file import load_trajectory

SEEDS = 10


def excite(folder: Path, *arguments: object) -> float:
    """One command with everything in it; its CPU seconds."""
    command = [sys.executable, "-m", "orbident.cli.app", "excite"]
    command += [*map(str, arguments), "--quiet", "-o", "made.yaml"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, cwd=folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize(
    ("robot", "bar", "seconds"),
    [
        ("paper-spatial", 5.45, 8),
        # The least that was found under the limits of Eq. 46 at all times is 23.3.
        ("cepheus-like", 23.6, 8),
    ],
)
@pytest.mark.benchmark(group="like the paper")
def bench_like_paper(benchmark, record, tmp_path, robot, bar, seconds, once, meets):
    """The median of five seeds, and the seconds of one."""
    effort = ("--starts", 1) if once else ()

    def designed(seed):
        cpu = excite(tmp_path, robot, "--like-paper", "--seed", seed, *effort)
        made = load_trajectory(tmp_path / "made.yaml").design
        assert made is not None
        return made["value"], cpu

    first = benchmark.pedantic(designed, (0,), rounds=1)
    values, cpus = np.transpose([first, *map(designed, () if once else range(1, 5))])
    cond = float(np.median(values))
    wall = record(robot, cond=cond, worst=max(values), cpu_seconds=float(cpus.mean()))
    meets(cond <= bar)
    meets(wall < seconds)  # on an idle machine


@pytest.mark.benchmark(group="dual-arm")
def bench_dual_arm(benchmark, record, once, meets):
    """14 joints: the deviations of all 125 parameters, against random motions."""
    robot = load_robot("dual-arm")
    given = conditions_for(robot, 80.0, harmonics=5)
    design = partial(
        design_excitation,
        robot,
        objective="a",
        budget=1.0 if once else 60.0,
        conditions=given,
    )
    made = benchmark.pedantic(design, rounds=1).design
    wall = record("dual-arm", value=made["value"], random=made["median_random_start"])
    meets(made["median_random_start"] > 10 * made["value"])
    meets(wall < 120)


@pytest.mark.benchmark(group="differences")
def bench_against_finite_differences(benchmark, record, once, meets):
    """SLSQP from one start, as toolboxes do: gradients by differences.

    The same motion, criterion, limits and start.
    """
    robot = load_robot("paper-spatial")
    given = paper_case(robot).conditions
    problem = problem_for(robot, given, "cond", 0.0)
    polytope = polytope_of(problem.motions.resampled(LIMIT_STEPS + 1), given.limits)
    middle = inner_point(polytope, given.limits, dict(enumerate(robot.joint_names)))
    direction = np.random.default_rng([0, 0]).standard_normal(middle.shape)
    y = middle + 0.8 * polytope.reach(middle, direction)[:, None] * direction

    def theirs():
        return minimize(
            lambda x: problem.evaluate(x.reshape(middle.shape), 8.0).exact,
            y.ravel(),
            constraints={
                "type": "ineq",
                "fun": lambda x: polytope.slack(x.reshape(middle.shape)).ravel(),
                "jac": lambda x: -polytope.rows,
            },
            method="SLSQP",
            options={"maxiter": 1 if once else 100},
        )

    found = benchmark.pedantic(theirs, rounds=1)
    slow = record("differences", cond=float(np.exp(found.fun)), calls=int(found.nfev))
    started = time.perf_counter()
    space = SearchSpace(problem, (polytope, polytope, polytope), middle)
    ours = JointSearch(Effort(1, None), lambda _: None, [space], 0).run()
    fast = time.perf_counter() - started
    cond = float(np.exp(ours.optima[0].value))
    benchmark.extra_info.update(ours_seconds=fast, ours_cond=cond)
    meets(fast < slow)


@pytest.mark.benchmark(group="monte carlo")
def bench_realised_errors(benchmark, record, once, meets):
    """Section 3.5's noise on Table 2's motion and on the designed one."""
    robot = load_robot("paper-spatial")
    case = paper_case(robot)
    designed = design_excitation(
        robot, objective="d", conditions=case.conditions, starts=1 if once else 6
    )
    pi = minimal_sets(robot).pi(robot.theta)

    def rms(trajectory):
        errors = []
        for seed in range(1 if once else SEEDS):
            noisy = simulate(robot, trajectory, noise="sensors", seed=seed, truth=True)
            result = identify(robot, with_attitude(noisy), "least-squares")
            errors.append(result.pi.values - pi)
        return np.sqrt(np.mean(np.square(errors), axis=0))

    theirs = rms(case.trajectory)
    ours = benchmark.pedantic(rms, (designed,), rounds=1)
    ratio = float(np.median(theirs / ours))
    record("monte carlo", median_ratio=ratio, worst_ratio=float((theirs / ours).min()))
    meets(ratio > 1)


def with_attitude(noisy: Recording) -> Recording:
    """The servicer measures no attitude: the true one, so that motions compare."""
    columns = dict(noisy.columns)
    for sensor in ("attitude.x", "attitude.y", "attitude.z", "attitude.w"):
        columns[sensor] = columns[f"truth.{sensor}"]
    return Recording(noisy.t, columns)
