"""`H+` and `c+` of the dual-arm robot in many states, against Pinocchio and MuJoCo.

Ours is the batched method of identified dynamics. Pinocchio has the composite rigid
body algorithm and the recursive Newton-Euler algorithm, in a Python loop as they are
used; MuJoCo computes both in every step, here the only one of as many rollouts, in two
threads and without Python between.
"""

# Pinocchio and MuJoCo are compiled, and have no stubs for what they export.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import mujoco
import mujoco.rollout
import numpy as np
import pinocchio as pin
import pytest
from manoeuvres import dual_arm
from mujoco_runs import floating_model
from pinocchio_model import pinocchio_model

from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.robot.description import Robot

STATES = 4096
THREADS = 2
GROUP = "H+ and c+, 4096 states"


class States(NamedTuple):
    q: np.ndarray
    v: np.ndarray


@pytest.fixture(scope="module")
def robot() -> Robot:
    return dual_arm()


@pytest.fixture(scope="module")
def states(robot: Robot) -> States:
    random, joints = np.random.default_rng(0), len(robot.joints)
    speeds = 6 + joints + len(robot.wheels)
    return States(
        random.standard_normal((STATES, joints)),
        random.standard_normal((STATES, speeds)),
    )


@pytest.fixture(scope="module")
def identified(robot: Robot) -> Dynamics:
    beta = minimal_sets(robot).beta(robot.theta)
    return reconstructed(robot, beta, np.full((beta.size, beta.size), np.nan))


@pytest.fixture(scope="module")
def theirs(robot: Robot, states: States):
    """Pinocchio's loop over the states, wheels left out; its speeds are those of S."""
    pinocchio = pinocchio_model(robot)
    model, data = pinocchio.model, pinocchio.model.createData()
    q = [pinocchio.q(each) for each in states.q]
    v = np.zeros((STATES, model.nv))
    v[:, pinocchio.rows] = states.v[:, : model.nv]
    H, c = np.empty((STATES, model.nv, model.nv)), np.empty((STATES, model.nv))

    def loop():
        for k in range(STATES):
            H[k] = pin.crba(model, data, q[k])
            c[k] = pin.nonLinearEffects(model, data, q[k], v[k])
        return H, c

    return loop, pinocchio.rows


@pytest.mark.benchmark(group=GROUP)
def bench_orbident(benchmark, record, robot, states, identified, theirs):
    benchmark(lambda: identified.equations(*states))
    median = record("orbident")
    benchmark.extra_info["us_per_state"] = 1e6 * median / STATES
    # What does not depend on where the speeds are taken: the joints' own block, with
    # the system CM at rest. H_qq = D_qq + J_cm^T M J_cm of S at rest.
    loop, rows = theirs
    upper = np.triu(loop()[0][0])
    H = (upper + np.triu(upper, 1).T)[np.ix_(rows, rows)]
    J_cm = H[:3, 6:] / robot.mass
    relative = H[6:, 6:] - robot.mass * J_cm.T @ J_cm
    found = identified.H_plus(states.q[0])[6 : rows.size, 6 : rows.size]
    difference = np.abs(found - relative).max() / np.abs(relative).max()
    benchmark.extra_info["difference"] = difference
    assert difference < 1e-12


@pytest.mark.benchmark(group=GROUP)
def bench_pinocchio(benchmark, record, medians, theirs, meets):
    loop, _ = theirs
    benchmark(loop)
    meets(compared(benchmark, record("pinocchio"), medians) > 1)


@pytest.mark.benchmark(group=GROUP)
def bench_mujoco(benchmark, record, medians, robot, states, meets):
    """One step from each state, without constraints, contacts or gravity."""
    model = floating_model(robot, armature=0.0)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    random, kind = np.random.default_rng(0), mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros((STATES, mujoco.mj_stateSize(model, kind)))
    # The time comes first; quaternions are normalised by MuJoCo.
    start[:, 1 : 1 + model.nq + model.nv] = random.standard_normal(
        (STATES, model.nq + model.nv)
    )
    data = [mujoco.MjData(model) for _ in range(THREADS)]
    with mujoco.rollout.Rollout(nthread=THREADS) as threads:
        benchmark(lambda: threads.rollout(model, data, start, nstep=1))
    meets(compared(benchmark, record("mujoco.rollout"), medians) > 1)


def compared(benchmark, median: float, medians: dict[str, float]) -> float:
    """How many times slower it is; infinite where ours was not timed."""
    benchmark.extra_info["us_per_state"] = 1e6 * median / STATES
    ratio = median / medians["orbident"] if "orbident" in medians else np.inf
    benchmark.extra_info["ratio"] = ratio
    return ratio
