"""Momentum that walks at random: forms, densities, and intervals in every method."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from small_problems import small_problem, small_recording, small_robot

from orbident.environment.motion import at_nodes, by_step, integral
from orbident.environment.torques_and_forces import WAVES
from orbident.estimation.identify import Method, identify
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error import problem
from orbident.estimation.output_error.disturbance_sizes import most_likely_densities
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import MomentumWalk, Robot
from orbident.robot.may_act import may_act
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies.paper_tables import spatial_trajectory
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory
from orbident.trajectories.trajectory_file import load_trajectory

FAR = 4.0
"""Deviations."""

SEEDS = 40

PLANAR = """
schema: orbident/trajectory/1
duration: 20.0
joints:
  joint1: {a: [0.3, -0.1], b: [0.2, 0.1]}
  joint2: {a: [0.2, 0.2], b: [-0.3, 0.1]}
initial:
  angular_velocity: [0, 0, -2.3575567]
  wheel_speed: {rw: 200}
"""
"""The base turns against the wheel: together they are at rest."""


class Walking(NamedTuple):
    robot: Robot
    trajectory: Trajectory
    walk: MomentumWalk
    rate: float
    """Hz."""
    known: InitialMomentum
    """What is known of the momentum at the start."""

    def recorded(self, seed: int) -> Recording:
        """Torque and force are independent at each row, and straight between them.

        The sum over `n` rows of numbers of the deviation `s` times the time between
        them, `dt`, has the deviation `s sqrt(dt) sqrt(n dt)`.
        """
        once = {"correlation_time": 1e-3}
        root = np.sqrt(self.rate)
        acting = {
            f"slow_{name}": {"std": density * root, **once}
            for name, density in self.walk._asdict().items()
            if density
        }
        environment = Environment.model_validate(acting)
        trajectory = replace(self.trajectory, environment=environment)
        return simulate(self.robot, trajectory, noise="sensors", seed=seed)

    def declared(self) -> Robot:
        return replace(self.robot, momentum_walk=self.walk)

    def asked(self) -> Robot:
        return replace(self.robot, disturbances=may_act(self.declared().said_to_act))

    def identified(
        self, robot: Robot, seed: int, method: Method = "maximum-likelihood"
    ) -> Result:
        return identify(robot, self.recorded(seed), method, self.known)

    def off(self, result: Result) -> np.ndarray:
        """Errors in their deviations of the base parameters that are determined."""
        true = minimal_sets(self.robot).beta(self.robot.theta)
        base = result.base
        off = (base.values - true) / base.std
        return off[np.isfinite(off)]


def written(folder: Path, text: str) -> Trajectory:
    path = folder / "motion.yaml"
    path.write_text(text)
    return load_trajectory(path)


@pytest.fixture(scope="module")
def space() -> Walking:
    # A force would act at S, which is a metre from the CM, and not through the CM.
    robot = load_robot("paper-spatial")
    walk = MomentumWalk(torque=2e-3)
    return Walking(robot, spatial_trajectory(robot), walk, 20.0, "unknown")


@pytest.fixture(scope="module")
def table(tmp_path_factory) -> Walking:
    trajectory = written(tmp_path_factory.mktemp("table"), PLANAR)
    walk = MomentumWalk(torque=1e-4, force=5e-4)
    return Walking(load_robot("cepheus-like"), trajectory, walk, 100.0, "at-rest")


def made_waves() -> tuple[np.ndarray, list[np.ndarray]]:
    """Times and the waves of a torque about z, of density one."""
    robot = small_robot()
    problem = small_problem(robot, small_recording(robot)).problem
    acting = problem.acting.walking({"torque_walk": 1.0})
    waves = [
        each for each in acting.followed.disturbances if each.group == "torque_walk"
    ]
    return acting.followed.t, [at_nodes(each.effect.torque)[:, 2] for each in waves]


def test_waves_are_orthonormal():
    t, waves = made_waves()
    products = np.trapezoid(np.array(waves)[:, None] * np.array(waves), t, axis=-1)
    # The trapezoidal rule is exact for these products but for rounding.
    np.testing.assert_allclose(products, np.eye(WAVES + 1), atol=1e-9)


def test_their_integrals_add_up_to_a_walk():
    """The variance after a time `t` is `q^2 t`, but for the waves that are left out."""
    t, waves = made_waves()
    T = t[-1] - t[0]
    walked = [integral(t, by_step(wave[:, None]))[:, 0] for wave in waves]
    variance = np.sum(np.square(walked), axis=0)
    np.testing.assert_allclose(variance, t - t[0], atol=2 * T / (np.pi**2 * WAVES))
    assert abs(variance[-1] / T - 1) < 1e-9


def test_the_most_likely_density():
    """Drawn many times: its logarithm is right within its deviation."""
    random = np.random.default_rng(3)
    R = np.triu(random.standard_normal((40, 40))) * 10 ** random.uniform(-2, 2, 40)
    q, off = 0.3, []
    for _ in range(100):
        z = q * R @ random.standard_normal(40) + random.standard_normal(40)
        (found,) = most_likely_densities([R], z, np.eye(40), [1.0])
        off.append(np.log(found.value / q) * found.value / found.std)
    # Of 100 draws: the mean is within 0.1, the deviation within 0.07, times 3.
    assert abs(np.mean(off)) < 0.3
    assert abs(np.std(off) - 1) < 0.25


@pytest.mark.slow
@pytest.mark.parametrize("where", ["space", "table"])
def test_a_declared_walk(where, request):
    flown = request.getfixturevalue(where)
    methods: tuple[Method, ...] = ("maximum-likelihood", "structured", "recursive")
    results = [flown.identified(flown.declared(), 1, method) for method in methods]
    for result in results:
        assert (result.status, result.level) == ("ok", "trust")
        assert np.abs(flown.off(result)).max() < FAR
    # All methods know the same: deviations are nearly equal.
    likeliest = results[0].base.std
    for result in results[1:]:
        own = result.base.std
        known = np.isfinite(own)
        np.testing.assert_allclose(own[known], likeliest[known], rtol=0.25)


@pytest.mark.parametrize(
    "where", ["table", pytest.param("space", marks=pytest.mark.slow)]
)
def test_a_walk_of_unknown_size(where, request):
    flown = request.getfixturevalue(where)
    result = flown.identified(flown.asked(), 2)
    assert (result.status, result.level) == ("ok", "trust")
    assert np.abs(flown.off(result)).max() < FAR
    for name in flown.asked().disturbances:
        true = getattr(flown.walk, name.removesuffix("_walk"))
        found = result.disturbances[name]
        assert abs(np.log(found.value / true)) < FAR * found.std / found.value


@pytest.mark.slow
def test_where_nothing_walks_the_density_is_small(space):
    """An unneeded walk costs some width of intervals, and no bias."""
    still = space._replace(walk=MomentumWalk())
    result = still.identified(
        replace(space.robot, disturbances=may_act(["torque_walk"])), 3
    )
    assert result.status == "ok"
    assert result.disturbances["torque_walk"].value < 0.1 * space.walk.torque
    assert np.abs(still.off(result)).max() < FAR


@pytest.mark.slow
def test_a_walk_too_weak_to_show_is_left_out(space, monkeypatch):
    """Its 75 waves change no number; that it is declared is in the result."""
    weak = space._replace(walk=MomentumWalk(torque=1e-9))
    known = momentum_problem(
        weak.declared(), weak.recorded(4), "unknown", lambda _: None
    )
    shorter = OutputError().estimate(known, lambda _: None)
    monkeypatch.setattr(problem, "NEGLIGIBLE", -1.0)
    whole = OutputError().estimate(known, lambda _: None)
    assert shorter.solution
    assert whole.solution
    more = whole.solution.state.selected.size - shorter.solution.state.selected.size
    assert more == 3 * (WAVES + 1)
    one, other = shorter.parameters.base, whole.parameters.base
    std = np.sqrt(np.diag(other.covariance))
    assert np.abs((one.values - other.values) / std).max() < 1e-2
    np.testing.assert_allclose(np.sqrt(np.diag(one.covariance)), std, rtol=1e-2)
    assert shorter.disturbances["torque_walk"].value == 1e-9


@pytest.mark.long
@pytest.mark.parametrize("where", ["space", "table"])
@pytest.mark.parametrize(
    ("said", "method"),
    [
        ("declared", "maximum-likelihood"),
        ("asked", "maximum-likelihood"),
        ("declared", "structured"),
        ("declared", "recursive"),
    ],
)
def test_intervals(where, said, method, request):
    """Of 40 seeds: the mean of so many correlated errors is known to some 3 %."""
    flown = request.getfixturevalue(where)
    robot = getattr(flown, said)()
    results = [flown.identified(robot, seed, method) for seed in range(SEEDS)]
    kept = [result for result in results if result.status == "ok"]
    off = np.concatenate([flown.off(result) for result in kept])
    held = float(np.mean(np.abs(off) < 1.96))
    print(f"{where}, {said}, {method}: {len(kept)} of {SEEDS}, {held:.3f} held")
    assert len(kept) >= SEEDS - 1
    assert 0.90 < held < 0.99


@pytest.mark.slow
def test_every_method_takes_a_walk_of_unknown_size_into_account(space):
    """It is known once maximum likelihood has followed the momentum."""
    for method in ("least-squares", "structured"):
        result = space.identified(space.asked(), 2, method)
        assert result.status == "ok", result.warnings
        assert np.abs(space.off(result)).max() < FAR
