"""Recursive least squares against least squares, and what it does with bad samples."""

from typing import Literal

import numpy as np
import pytest
from random_motions import random_motion

from orbident.errors import InputError
from orbident.estimation.least_squares import Fits, fit
from orbident.estimation.recursive.linear import Linear, LinearState
from orbident.estimation.recursive.sample import Sample, stream
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.robot_file import load_robot
from orbident.sensing.simulate import simulate
from orbident.signals.samples import Samples, samples_of

# Both fold the same rows in different batches: rounding, times a condition of 100.
EXACT = 1e-9


def samples_for(name: str, noise: Literal["none", "sensors"] = "none") -> Samples:
    robot = load_robot(name)
    motion = random_motion(robot, duration=8.0)
    return samples_of(robot, simulate(robot, motion, rate=20.0, noise=noise))


def run(name: str, every: list[Sample], drift: bool, forgetting: float = 1.0):
    robot = load_robot(name)
    linear = Linear.of(robot, minimal_sets(robot), drift, forgetting)
    state = linear.start()
    for sample in every:
        state, _ = linear.step(state, sample)
    return linear, state


def check_same(linear: Linear, state: LinearState, batch: Fits) -> None:
    for found, expected in zip(
        linear.estimate(state), (batch.pi, batch.phi), strict=True
    ):
        size = np.abs(expected.values).max()
        np.testing.assert_allclose(found.values, expected.values, atol=EXACT * size)


@pytest.mark.parametrize("name", ["paper-spatial", "cepheus-like"])
def test_it_is_least_squares_whatever_the_order(name: str):
    robot, samples = load_robot(name), samples_for(name)
    batch = fit(robot, minimal_sets(robot), samples, "unknown", lambda _: None)
    every = list(stream(samples))
    shuffled = [every[k] for k in np.random.default_rng(0).permutation(len(every))]
    for order in (every, shuffled):
        check_same(*run(name, order, bool(samples.drift)), batch)


def test_an_accelerometers_bias_is_an_unknown():
    robot = load_robot("paper-spatial")
    samples = samples_for("paper-spatial", noise="sensors")
    assert samples.drift
    batch = fit(robot, minimal_sets(robot), samples, "unknown", lambda _: None)
    linear, state = run("paper-spatial", list(stream(samples)), drift=True)
    check_same(linear, state, batch)
    found = linear.estimate(state)[1]
    # The covariance too: what went in was counted.
    np.testing.assert_allclose(found.rms, batch.phi.rms, rtol=1e-6)


def test_the_residual_is_the_sum_of_the_innovations():
    robot = load_robot("paper-spatial")
    samples = samples_for("paper-spatial", noise="sensors")
    linear = Linear.of(robot, minimal_sets(robot), accelerometer=True)
    state, total = linear.start(), 0.0
    for sample in stream(samples):
        state, info = linear.step(state, sample)
        total += info.momentum
    unexplained = linear.estimate(state)[0].unexplained
    # What is summed up and rounds is the residual of all samples.
    assert total == pytest.approx(unexplained**2, rel=1e-6)


def test_forgetting_leaves_the_last_samples():
    """Of two halves with other truths only the second one shows."""
    samples = samples_for("paper-spatial")
    every = list(stream(samples))
    half = len(every) // 2
    wrong = [s._replace(qd_rw=2.0 * s.qd_rw, v_S=2.0 * s.v_S) for s in every[:half]]
    linear, state = run("paper-spatial", wrong + every[half:], False, forgetting=0.6)
    fresh, latest = run("paper-spatial", every[half:], False, forgetting=0.6)
    found, expected = linear.estimate(state)[1], fresh.estimate(latest)[1]
    # 0.6 to the power of 80 samples: 2e-18 of the squares.
    np.testing.assert_allclose(found.values, expected.values, atol=1e-6)


@pytest.mark.parametrize("sensor", ["w", "x_WB", "q"])
def test_samples_without_a_sensor_do_not_count(sensor: str):
    every = list(stream(samples_for("paper-spatial")))[:50]
    _, state = run("paper-spatial", every, False)
    holes = [
        s._replace(**{sensor: np.full_like(getattr(s, sensor), np.nan)}) for s in every
    ]
    linear, after = run("paper-spatial", every + holes, False)
    np.testing.assert_array_equal(after.R_h, state.R_h)
    assert linear.pi.parameters == 19


def test_without_velocity_the_momentum_counts():
    every = list(stream(samples_for("paper-spatial")))[:50]
    blind = [s._replace(v_S=np.full(3, np.nan)) for s in every]
    _, state = run("paper-spatial", every, False)
    _, after = run("paper-spatial", blind, False)
    np.testing.assert_array_equal(after.R_h, state.R_h)
    assert not after.R_v.any()
    assert after.weight_v == 0.0


@pytest.mark.parametrize("forgetting", [0.0, -1.0, 1.1, np.nan])
def test_forgetting_is_a_fraction(forgetting: float):
    robot = load_robot("paper-spatial")
    with pytest.raises(InputError, match="forgetting"):
        Linear.of(robot, minimal_sets(robot), False, forgetting)
