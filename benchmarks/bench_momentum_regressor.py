"""The momentum regressor of a dual-arm robot against Pinocchio's, per sample.

Rows 0 to 5 of Pinocchio's joint-torque regressor without gravity, at rest and with the
rates for accelerations, are the momentum: `P` and `A`.
"""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from manoeuvres import dual_arm
from pinocchio_model import pinocchio_model

from orbident import _core
from orbident.model.core_robot import core_tree
from orbident.robot.parameters import PER_BODY

FASTER = 3
SAMPLES = 3000


class States(NamedTuple):
    q: np.ndarray
    qd: np.ndarray
    w: np.ndarray


@pytest.fixture(scope="module")
def states() -> States:
    random = np.random.default_rng(0)
    joints = len(dual_arm().joints)
    q, qd = random.standard_normal((2, SAMPLES, joints))
    return States(q, qd, random.standard_normal((SAMPLES, 3)))


def ours(states: States, threads: int = 1) -> np.ndarray:
    """Linear, then angular momentum: six rows a sample, as Pinocchio gives them."""
    _, P, A = _core.momentum(core_tree(dual_arm()), *states, threads)
    return np.concatenate([P, A], axis=1)


@pytest.fixture(scope="module")
def theirs(states):
    """A loop over the samples, and where our columns are in its rows."""
    robot = pinocchio_model(dual_arm())
    model, data = robot.model, robot.model.createData()
    configurations = [robot.q(q) for q in states.q]
    velocities = [robot.v(w, qd) for qd, w in zip(states.qd, states.w, strict=True)]
    at_rest = np.zeros(model.nv)
    rows = np.empty((SAMPLES, 6, PER_BODY * len(robot.bodies)))

    def loop():
        for k in range(SAMPLES):
            rows[k] = pin.computeJointTorqueRegressor(
                model, data, configurations[k], at_rest, velocities[k]
            )[:6]
        return rows

    columns = [np.arange(PER_BODY) + PER_BODY * (body - 1) for body in robot.bodies]
    return loop, np.concatenate(columns)


@pytest.fixture(scope="module")
def difference(states, theirs) -> float:
    """The largest between the two, beside the largest entry."""
    loop, columns = theirs
    expected = loop()[:, :, columns]
    found = ours(states)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.benchmark(group="momentum regressor, 3000 samples")
@pytest.mark.parametrize("threads", [1, 2])
def bench_orbident(benchmark, record, states: States, difference, threads):
    tree = core_tree(dual_arm())
    benchmark(lambda: _core.momentum(tree, *states, threads))
    median = record(f"orbident, {threads} threads", difference=difference)
    benchmark.extra_info["us_per_sample"] = 1e6 * median / SAMPLES
    np.testing.assert_array_equal(ours(states, threads), ours(states))
    assert difference < 1e-12


@pytest.mark.benchmark(group="momentum regressor, batches")
@pytest.mark.parametrize("samples", [32, 256, 1000])
@pytest.mark.parametrize("threads", [1, 2])
def bench_batches(benchmark, record, states, samples, threads):
    tree, batch = core_tree(dual_arm()), States(*(x[:samples] for x in states))
    benchmark(lambda: _core.momentum(tree, *batch, threads))
    median = record(f"orbident, {samples} samples, {threads} threads")
    benchmark.extra_info["us_per_sample"] = 1e6 * median / samples
    np.testing.assert_array_equal(ours(batch, threads), ours(batch))


@pytest.mark.benchmark(group="momentum regressor, 3000 samples")
def bench_pinocchio(benchmark, record, medians, theirs, meets):
    loop, _ = theirs
    benchmark(loop)
    median = record("pinocchio")
    benchmark.extra_info["us_per_sample"] = 1e6 * median / SAMPLES
    if "orbident, 1 threads" in medians:
        benchmark.extra_info["ratio"] = median / medians["orbident, 1 threads"]
        meets(median >= FASTER * medians["orbident, 1 threads"])
