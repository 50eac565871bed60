"""Least squares on 3000 samples of the dual-arm robot, once compiled."""

import numpy as np
import pytest
from manoeuvres import dual_arm, excitation

from orbident.estimation.identify import identify
from orbident.regressors.minimal_sets import minimal_sets
from orbident.sensing.simulate import simulate

SECONDS = 0.5
SAMPLES = 3000
DURATION = 60.0


@pytest.fixture(scope="module")
def robot():
    return dual_arm()


@pytest.fixture(scope="module")
def recording(robot):
    rate = (SAMPLES - 1) / DURATION
    return simulate(robot, excitation(robot, DURATION), rate=rate)


@pytest.mark.benchmark(group="dual-arm")
def bench_identify(benchmark, record, robot, recording):
    assert recording.t.size == SAMPLES
    result = identify(robot, recording)
    benchmark.pedantic(identify, args=(robot, recording), rounds=9)
    expected = minimal_sets(robot).pi(robot.theta)
    error = np.abs(result.pi.values - expected).max() / np.abs(expected).max()
    mass_error = abs(result.mass.value / robot.mass - 1)
    median = record(
        "identify",
        samples=result.samples,
        parameters=len(result.pi.names),
        worst_pi_error=float(error),
        mass_error=mass_error,
    )
    assert result.status == "ok"
    assert error < 1e-9
    assert median < SECONDS


@pytest.mark.benchmark(group="dual-arm")
def bench_minimal_sets(benchmark, record, robot):
    """The part of it that depends on the robot alone."""
    sets = minimal_sets(robot)
    # Under the cache, which would answer at once.
    benchmark.pedantic(minimal_sets.__wrapped__, args=(robot,), rounds=9)
    record("minimal sets", pi=len(sets.pi_of_beta), phi=sets.base.sigmas)
