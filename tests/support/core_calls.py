"""A call of every function of the core, with arguments that it takes."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from random_robots import random_quaternion
from segments import segment_of

from orbident import _core
from orbident.estimation.output_error.problem import SENSORS
from orbident.estimation.recursive.driven_joints import DrivenJoints
from orbident.estimation.recursive.filter import Extended, cad_prior
from orbident.estimation.recursive.filter_input import declared_noise
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

ROWS = 5
"""Of most arrays."""

THREADS = 2


class Call(NamedTuple):
    """A function of the core, a class or a method, and its arguments."""

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    named: tuple[str, ...]
    """The last of them."""

    def again(self, arguments: tuple[Any, ...]) -> Any:
        """The same call with other arguments."""
        first = len(arguments) - len(self.named)
        named = dict(zip(self.named, arguments[first:], strict=True))
        return self.function(*arguments[:first], **named)


class Calls:
    """Calls that were made."""

    def __init__(self) -> None:
        self.made: list[Call] = []

    def make(self, name: str, *arguments: Any) -> Any:
        """Call `Class.method` or a function by its name."""
        function = _core
        for part in name.split("."):
            function = getattr(function, part)
        return self.recorded(name, function)(*arguments)

    def recorded(self, name: str, function: Any) -> Callable[..., Any]:
        """The function, which keeps its arguments."""

        def called(*arguments: Any, **named: Any) -> Any:
            every = (*arguments, *named.values())
            self.made.append(Call(name, function, every, tuple(named)))
            return function(*arguments, **named)

        return called

    def watch(self, names: tuple[str, ...], run: Callable[[], Any]) -> Any:
        """Keep what these functions are given meanwhile."""
        with pytest.MonkeyPatch.context() as patch:
            for name in names:
                called = self.recorded(name, getattr(_core, name))
                patch.setattr(_core, name, called)
            return run()


def core_calls(robot: Robot) -> list[Call]:
    """Those of one robot, with a joint and a wheel at least."""
    calls, random = Calls(), np.random.default_rng(0)
    tree, made = _robot(calls, robot, random)
    _rigid_bodies(calls, robot, tree, made, random)
    _tables(calls, len(robot.joints), random)
    filter_names = ("MinimalSets", "SensorNoise", "Filter")
    gyro = declared_sensors({"gyro": {"angle_random_walk": 1e-4}})
    walk = replace(robot, sensors=gyro)
    driven = DrivenJoints(np.array([[0.0, *np.full(12, 0.1)]]), 10.0)
    noise = declared_noise(walk, 0.1, 1e-3)._replace(driven=driven)
    kalman = calls.watch(filter_names, lambda: Extended.of(walk, noise))
    _filter(calls, walk, kalman, random)
    _excitation(calls, robot, made, kalman.sets.regressors.core, random)
    _output_error(calls, robot)
    return calls.made


def _robot(calls: Calls, robot: Robot, random: np.random.Generator) -> tuple[Any, Any]:
    joints, wheels = robot.joints, len(robot.wheels)
    tree = calls.make(
        "Tree",
        np.array([joint.parent for joint in joints], dtype=float),
        np.array([joint.kind == "revolute" for joint in joints], dtype=float),
        np.array([joint.axis for joint in joints]),
        np.array([joint.R_PJ for joint in joints]),
        np.array([joint.p_PJ for joint in joints]),
    )
    axes = random.standard_normal((wheels, 3))
    theta, armature = robot.theta.copy(), np.ones(len(robot.joints))
    return tree, calls.make("Robot", tree, theta, armature, axes, np.ones(wheels))


def _rigid_bodies(
    calls: Calls, robot: Robot, tree: Any, made: Any, random: np.random.Generator
) -> None:
    n, K, W = ROWS, len(robot.joints), len(robot.wheels)
    N, thetas = 6 + K + W, 10 * (K + 1)
    draw, make, one, each = random.standard_normal, calls.make, np.ones(K), np.ones(W)
    q, qd, w, v = draw((n, K)), draw((n, K)), draw((n, 3)), draw((n, N))
    t, unit, zero = np.arange(float(n)), random_quaternion(random), np.zeros((3, 3))
    make("poses", tree, q, THREADS)
    make("momentum", tree, q, qd, w, THREADS)
    make("masses", made, q, True)
    make("inertia", made, q, THREADS)
    make("equations_of_motion", made, q, v, THREADS)
    make("deviations", made, draw((2, K + 1, 10)), q, v, THREADS)
    make("momentum_terms", tree, draw((thetas, 4)), draw(4), q[0], qd[0], qd[1])
    make("joint_momenta", tree, draw((thetas, 4)), draw((n, 4)), q, qd, w)
    make("floating_laws", made, q, qd, zero, np.ones(3), False, THREADS)
    nodes = 4 * (n - 1) + 1
    E, b, h = np.tile(np.eye(3), (nodes, 1, 1)), draw((nodes, 3)), np.ones((nodes, 3))
    make("rate_laws", E, b, False, THREADS)
    make("attitudes", E, b, h, unit, t, 2)
    x = np.tile(unit, (n, 1))
    make("floating_motion", made, q, qd, E[:n], b[:n], h[:n], x, THREADS)
    make("forward_dynamics", made, q, v, v, v, np.ones(N), THREADS)
    computed = make("ComputedTorque", made, np.ones((W, 3)), 1.0, 1.0)
    laws = (np.ones(N), one, one, each, each, np.ones((W, 3)), 1.0, 1.0, unit)
    limits = (each, each, np.array([0.0, K]), np.ones((2, 3)), computed)
    vehicle = make("Vehicle", made, *laws, *limits)
    state = np.concatenate([draw(K), unit, draw(W), draw(N), draw(3)])
    command = draw((2, 3, 4 * K + W + 22))
    make("fly", vehicle, state, np.full(2, 0.1), command, np.ones(2))


def _tables(calls: Calls, K: int, random: np.random.Generator) -> None:
    n, draw, make = ROWS, random.standard_normal, calls.make
    t, w = np.arange(float(n)), draw((n, 3))
    make("give_back_memory")
    make("integrate_rate", random_quaternion(random), t, w, w)
    B = np.tile(np.eye(3), (n - 1, 1, 1))
    make("smooth_gyro_error", B, t[1:], w, np.ones(3), np.ones(2))
    make("fold", np.eye(3), w)
    make("expected_samples", np.arange(30.0), draw(30), 3, THREADS)
    two = (np.ones(2), np.ones(2), np.ones(2), np.zeros(2), THREADS)
    make("smooth_columns", t, draw((n, 2)), *two)
    make("smooth_rates", t, draw((n, 2)), *two)
    make("smoothing_evidence", np.tile(t, (2, 1)), draw((2, n)), np.ones(3), THREADS)
    make("fourier_quintic", draw((3, K, 10)), t, THREADS)
    make("innovations", t, w, np.ones(n), np.ones(4))


def _filter(
    calls: Calls, robot: Robot, kalman: Extended, random: np.random.Generator
) -> None:
    core, prior, make = kalman.core, cad_prior(robot), calls.make
    K, W = len(robot.joints), len(robot.wheels)
    t, samples = np.arange(float(ROWS)), random.standard_normal((ROWS, 2 * K + W + 17))
    state = make("Filter.start", core, prior.beta, prior.root, samples[0], np.ones(3))
    state, *_ = make("Filter.step", core, state, 0.0, samples[0])
    make("Filter.opened", core, state, np.eye(len(prior.beta)), 0.5)
    make("Filter.restored", core, state.numbers)
    make("Filter.gathered", core, state, t, samples, THREADS)
    make("Filter.scaled", core, state, 100.0)
    watch = make("Watch", kalman.rows, 3)
    watch, *_ = make("Watch.step", watch, 0.0, np.ones(kalman.rows))
    make("Watch.restored", kalman.rows, 3, watch.numbers)
    make("Filter.run", core, state, watch, 1e9, t, samples)
    make("flight_tables", core)
    make("flight_memory", core, 3)


def _excitation(
    calls: Calls, robot: Robot, made: Any, sets: Any, random: np.random.Generator
) -> None:
    n, K, draw, make = ROWS, len(robot.joints), random.standard_normal, calls.make
    q, qd, w = draw((n, K)), draw((n, K)), draw((n, 3))
    Y, W = make("regressors", sets, q, qd, w, THREADS)
    make("momentum_rate", sets, q, qd, qd, w, np.ones(Y.shape[2]), THREADS)
    at = (np.zeros((3, 3)), np.ones(3), w[0], random_quaternion(random))
    floating = make("Floating", made, False, *at)
    rate, x_WB, laws = make("float_along", floating, q, qd, 0.1, THREADS)
    m = len(rate)
    by = (Y[:m].copy(), W[:m].copy(), np.ones((m, 3, 3)), w[:m], w[:m], w[:m])
    along = (floating, laws, sets, q, qd, 0.1, rate, x_WB)
    make("float_gradient", *along, *by, THREADS)
    make("momentum_gradient", made, q, qd, w, w, w, THREADS)


def _output_error(calls: Calls, robot: Robot) -> None:
    names = (
        *("Recorded", "linearised", "changes_factor"),
        *("interval_equations", "boundaries"),
    )

    def run() -> None:
        segment = segment_of(robot, 3, rows=8, intervals=2)
        segment.equations(*SENSORS)
        found = segment.eliminated(THREADS)
        found.step(np.zeros(len(segment.state.common)))
        segment.changed([segment_of(robot, 4, rows=8, intervals=2)], THREADS)

    calls.watch(names, run)
