"""Maximum likelihood and recursion on the paper's servicer, and how they grow."""

import time

import numpy as np
import pytest
from manoeuvres import dual_arm, excitation

from orbident.estimation.identify import identify
from orbident.estimation.recursive.filter import Extended, cad_prior
from orbident.estimation.recursive.filter_input import filter_input_of
from orbident.estimation.recursive.history import Detector
from orbident.preprocessing.samples import samples_of
from orbident.simulation.simulate import simulate
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

SECONDS = 0.15
DUAL_ARM_SECONDS = 2.0
STEP_SECONDS = 5e-6
DUAL_ARM_STEP_SECONDS = 60e-6
LONG = 100_000


@pytest.fixture(scope="module")
def robot():
    return spatial_robot()


@pytest.fixture(scope="module")
def recording(robot):
    return simulate(robot, spatial_trajectory(robot), noise="sensors")


@pytest.fixture(scope="module")
def dual_arm_recording():
    motion = excitation(dual_arm(), duration=150.0)
    return simulate(dual_arm(), motion, rate=20.0, noise="sensors")


@pytest.mark.benchmark(group="paper-spatial")
def bench_identify(benchmark, record, robot, recording, meets):
    result = identify(robot, recording)
    benchmark.pedantic(identify, args=(robot, recording), rounds=5)
    error = abs(result.mass.value / robot.mass - 1)
    median = record("maximum likelihood", samples=result.samples, mass_error=error)
    assert error < 2e-3
    meets(median < SECONDS)


@pytest.mark.benchmark(group="dual-arm")
def bench_dual_arm(benchmark, record, dual_arm_recording, meets):
    """Fourteen joints, 108 base parameters, 3001 samples."""
    robot = dual_arm()
    result = benchmark.pedantic(identify, args=(robot, dual_arm_recording), rounds=3)
    error = abs(result.mass.value / robot.mass - 1)
    median = record("maximum likelihood", samples=result.samples, mass_error=error)
    assert error < 2e-3
    meets(median < DUAL_ARM_SECONDS)


@pytest.mark.benchmark(group="paper-spatial")
def bench_length(benchmark, record, robot, once, meets):
    """Time per sample, of ten thousand and of a hundred thousand."""
    trajectory = spatial_trajectory(robot)
    seconds = []
    for samples in (LONG // 100,) if once else (LONG // 10, LONG):
        rate = (samples - 1) / trajectory.duration
        long = simulate(robot, trajectory, rate=rate, noise="sensors")
        identify(robot, long)
        started = time.perf_counter()
        identify(robot, long)
        seconds.append(time.perf_counter() - started)
    benchmark.pedantic(lambda: None, rounds=1)
    record("length", seconds=seconds)
    meets(seconds[-1] < 12 * seconds[0])


@pytest.mark.benchmark(group="paper-spatial")
def bench_recursive_step(benchmark, record, robot, recording, meets):
    meets(recursion(benchmark, record, robot, recording) < STEP_SECONDS)


@pytest.mark.benchmark(group="dual-arm")
def bench_recursive_step_of_dual_arm(benchmark, record, dual_arm_recording, meets):
    """Once the filter has handed over; the first steps take ten times as long."""
    recursion(benchmark, record, dual_arm(), dual_arm_recording)
    meets(benchmark.extra_info["us_after"] < 1e6 * DUAL_ARM_STEP_SECONDS)


def recursion(benchmark, record, robot, recording) -> float:
    """Seconds a sample of a whole recording: step, detector and deviations.

    The means before and after the filter hands over to `beta` are in `extra_info`.
    """
    t, every, noise = filter_input_of(robot, samples_of(robot, recording))
    kalman = Extended.of(robot, noise)
    watch = Detector(kalman.rows, samples=t.size).start()
    state = kalman.begun(cad_prior(robot), every[0], None).core

    def run(state=state, part=slice(None)):
        return kalman.core.run(state, watch, np.inf, t[part], every[part])

    early, handed_over = state, 0
    while not early.held_in_beta:
        early = run(early, slice(handed_over, handed_over + 1))[0]
        handed_over += 1
    started = time.perf_counter()
    run(part=slice(handed_over))
    before = (time.perf_counter() - started) / handed_over
    _, _, done, _, beta, _, _ = benchmark.pedantic(run, rounds=5)
    assert np.isfinite(beta).all()
    seconds = record("recursion", steps=done, handed_over_after=handed_over)
    after = (seconds - handed_over * before) / (done - handed_over)
    benchmark.extra_info.update(us_before=1e6 * before, us_after=1e6 * after)
    return seconds / done
