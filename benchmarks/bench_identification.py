"""Least squares on 3000 samples of the dual-arm robot."""

from functools import partial

import numpy as np
import pytest
from manoeuvres import dual_arm, excitation

from orbident.estimation.base_parameters import mass_of
from orbident.estimation.identify import identify
from orbident.estimation.linear_fits import fit
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.simulation.simulate import simulate

SECONDS = 0.5
WHOLE_SECONDS = 1.0
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
def bench_identify(benchmark, record, robot, recording, meets):
    assert recording.t.size == SAMPLES
    arguments = robot, recording, "least-squares"
    result = identify(*arguments)
    benchmark.pedantic(identify, args=arguments, rounds=9)
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
    meets(median < WHOLE_SECONDS)


@pytest.mark.benchmark(group="dual-arm")
def bench_least_squares(benchmark, record, robot, recording, meets):
    """Samples to parameters and mass, without screening, clocks and words."""
    sets = minimal_sets(robot)
    least_squares = partial(_least_squares, robot, sets, recording)
    mass = least_squares()
    benchmark.pedantic(least_squares, rounds=9)
    median = record("least squares", mass_error=abs(mass / robot.mass - 1))
    meets(median < SECONDS)


def _least_squares(robot, sets, recording):
    fits = fit(robot, sets, samples_of(robot, recording), "unknown", lambda _: None)
    return mass_of(sets, fits.pi, fits.phi).value


@pytest.mark.benchmark(group="dual-arm")
def bench_minimal_sets(benchmark, record, robot):
    """The part of it that depends on the robot alone."""
    sets = minimal_sets(robot)
    # Under the cache, which would answer at once.
    benchmark.pedantic(minimal_sets.__wrapped__, args=(robot,), rounds=9)
    record("minimal sets", pi=len(sets.pi_of_beta), phi=sets.base.sigmas)
