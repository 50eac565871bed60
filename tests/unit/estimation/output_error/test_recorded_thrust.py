"""Recorded thrust: it gives the scale and the mass without any wheel."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from random_robots import random_robot

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.problem import problem_of
from orbident.estimation.output_error.sensors import sensors_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import delays
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Thruster
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.flight import FreeFlying, JointPD, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import measure_truth, truth_of_flight
from orbident.simulation.outside import Pulse

slow = partial(pytest.param, marks=pytest.mark.slow)

RATE, DURATION = 20.0, 60.0
"""Hz and s."""

TRUE = {"left": 1.0, "right": 1.08}
"""The force of each thruster, over that which is recorded."""

FORCE = 0.5
"""N, as recorded."""

PULSES = (
    ("left", 4.0, 9.0),
    ("right", 12.0, 17.0),
    ("right", 25.0, 28.0),
    ("left", 31.0, 36.0),
    ("right", 44.0, 47.0),
)


class Waving:
    """Two joints that swing."""

    def at(self, t):
        rate, phase = np.array([0.5, 0.8]), np.array([0.3, 1.1])
        angle = np.multiply.outer(t, rate) + phase
        wave = 0.9 * np.sin(angle), 0.9 * rate * np.cos(angle)
        return *wave, -(rate**2) * wave[0]


@pytest.fixture(scope="module")
def robot() -> Robot:
    """No wheel; one thruster is calibrated, the other to a tenth."""
    x, y = np.eye(3)[:2]
    sides = (
        Thruster("left", 0.4 * y + 0.1 * x, np.array([0.6, 0.0, 0.8]), 0.0),
        Thruster("right", -0.4 * y, np.array([0.8, 0.6, 0.0]), 0.1),
    )
    sensors = {
        "rate": RATE,
        "gyro": {"angle_random_walk": 2e-6},
        "joints": {"position": 2e-5},
        "attitude": {"angle": 2e-4},
        "position": {"std": 2e-4},
    }
    made = random_robot(11, (0, 1), base=10.0)
    return replace(made, thrusters=sides, sensors=declared_sensors(sensors))


@pytest.fixture(scope="module")
def flight(robot) -> FreeFlying:
    t = np.arange(round(DURATION * RATE) + 1) / RATE
    start = BaseState(np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3), np.zeros(0))
    law = JointPD(Kp=np.full(2, 50.0), Kd=np.full(2, 50.0))
    pulses = [Pulse(name, on, off, FORCE * TRUE[name]) for name, on, off in PULSES]
    q, _, _ = Waving().at(t[:1])
    return free_flying(robot, t, standing(start, q[0]), Waving(), law, pulses=pulses)


def recorded(robot: Robot, flight: FreeFlying, seed: int) -> Recording:
    """A recording of the flight, with what the thrusters were asked for."""
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), seed)
    columns = dict(seen.columns)
    for thruster in robot.thrusters:
        on = np.zeros(seen.t.size)
        for name, begin, end in PULSES:
            if name == thruster.name:
                on[(seen.t >= begin - 1e-9) & (seen.t < end - 1e-9)] = FORCE
        columns[f"thruster.{thruster.name}.force"] = on
    return replace(seen, columns=columns)


@pytest.mark.parametrize("seed", [0, slow(1)])
def test_without_wheels(robot, flight, seed):
    """All parameters, the mass, and the force of the thruster that is not known."""
    result = identify(robot, recorded(robot, flight, seed))
    assert result.status == "ok", result.warnings
    z = (result.base.values - minimal_sets(robot).beta(robot.theta)) / result.base.std
    assert np.isfinite(z).all()
    assert np.abs(z).max() < 4
    assert result.mass.std < 0.02 * robot.mass
    assert list(result.calibration) == ["thruster.right.gain"]
    gain = result.calibration["thruster.right.gain"]
    assert abs(gain.value - 0.08) < 4 * gain.std < 0.08
    assert not result.disturbances


@pytest.mark.parametrize("method", [slow("structured"), "least-squares"])
def test_by_other_methods(robot, flight, method):
    """What thrust has given to the momenta is a known term of Eqs. 24 and 31."""
    result = identify(robot, recorded(robot, flight, 0), method)
    assert result.status == "ok", result.warnings
    z = (result.base.values - minimal_sets(robot).beta(robot.theta)) / result.base.std
    assert np.abs(z).max() < 4
    assert result.mass.std < 0.02 * robot.mass


def test_beside_thrust_positions_are_needed(robot, flight):
    """A force turns the robot about the CM, and momentum alone does not show it."""
    seen = recorded(robot, flight, 0)
    columns = {k: x for k, x in seen.columns.items() if not k.startswith("position")}
    result = identify(robot, replace(seen, columns=columns))
    assert result.status == "rejected"
    assert result.refusal().endswith("(nor position.x .y .z); record one of them")


def test_the_recursion_needs_a_wheel(robot, flight):
    with pytest.raises(InputError, match="has no wheel, and recursive cannot find"):
        identify(robot, recorded(robot, flight, 0), "recursive")


@pytest.mark.parametrize(
    "method", ["recursive", *map(slow, ("structured", "least-squares"))]
)
def test_only_maximum_likelihood_takes_long_recordings(robot, flight, method):
    seen, repeated = recorded(robot, flight, 0), 8
    columns = {name: np.tile(x, repeated) for name, x in seen.columns.items()}
    t = np.arange(repeated * seen.t.size) / RATE
    with pytest.raises(InputError, match="recordings of at most 8192 samples"):
        identify(robot, replace(seen, t=t, columns=columns), method)


def test_there_is_no_such_thruster(robot, flight):
    seen = recorded(robot, flight, 0)
    columns = {**seen.columns, "thruster.rear.force": np.ones(seen.t.size)}
    with pytest.raises(InputError, match="no thruster 'rear', only 'left', 'right'"):
        identify(robot, replace(seen, columns=columns))


def as_duty(robot: Robot, seen: Recording) -> tuple[Robot, Recording]:
    """The same, as parts of a full thrust of four times as much."""
    full = tuple(replace(each, thrust=4 * FORCE) for each in robot.thrusters)
    columns = {
        name.replace(".force", ".duty"): x / (4 * FORCE) if ".force" in name else x
        for name, x in seen.columns.items()
    }
    return replace(robot, thrusters=full), replace(seen, columns=columns)


def as_net_wrench(robot: Robot, seen: Recording) -> Recording:
    """The same, as the net force and moment about S; each with its true gain."""
    columns = dict(seen.columns)
    force, torque = np.zeros((2, seen.t.size, 3))
    for thruster in robot.thrusters:
        newton = columns.pop(f"thruster.{thruster.name}.force") * TRUE[thruster.name]
        each = np.outer(newton, thruster.direction)
        force += each
        torque += np.cross(thruster.position - robot.feature_point, each)
    columns |= {f"force.{axis}": force[:, k] for k, axis in enumerate("xyz")}
    columns |= {f"torque.{axis}": torque[:, k] for k, axis in enumerate("xyz")}
    return replace(seen, columns=columns)


@pytest.mark.slow
def test_a_duty_is_a_part_of_the_full_thrust(robot, flight):
    seen = recorded(robot, flight, 0)
    with_duty, shown = as_duty(robot, seen)
    one, other = identify(robot, seen), identify(with_duty, shown)
    np.testing.assert_allclose(other.base.values, one.base.values, rtol=1e-9)


@pytest.mark.slow
def test_the_net_wrench_is_known_but_for_a_gain(robot, flight):
    """The whole scale is then as uncertain as the gain."""
    result = identify(robot, as_net_wrench(robot, recorded(robot, flight, 0)))
    assert result.status == "ok", result.warnings
    z = (result.base.values - minimal_sets(robot).beta(robot.theta)) / result.base.std
    assert np.abs(z).max() < 4
    assert list(result.calibration) == ["wrench.gain"]
    assert 0.08 < result.mass.std / robot.mass < 0.12


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda on: {"thruster.left.duty": 3 * on}, "row 81: found 1.5; a duty is"),
        (lambda on: {"thruster.left.duty": on}, "does not say; add 'thrust: 5'"),
        (
            lambda on: {"thruster.left.force": on, "thruster.left.duty": on},
            "'thruster.left.force' is there too",
        ),
        (
            lambda on: {f"force.{axis}": on for axis in "xyz"},
            "'torque.x .y .z' \\(about S\\) are missing",
        ),
        (
            lambda on: {
                **{f"{name}.{k}": on for name in ("force", "torque") for k in "xyz"},
                "thruster.left.force": on,
            },
            "they would count twice",
        ),
    ],
    ids=["above one", "no thrust", "both", "no torque", "twice"],
)
def test_columns_that_contradict(robot, flight, change, words):
    seen = recorded(robot, flight, 0)
    on = seen.column("thruster.left.force")
    columns = {n: x for n, x in seen.columns.items() if not n.startswith("thruster")}
    thrust = None if "does not say" in words else 1.0
    full = tuple(replace(each, thrust=thrust) for each in robot.thrusters)
    with pytest.raises(InputError, match=words):
        identify(
            replace(robot, thrusters=full),
            replace(seen, columns={**columns, **change(on)}),
        )


def test_the_clock_of_a_thruster_that_gives_nothing_changes_nothing(robot, flight):
    """It has a column all the same, beside that of the gain."""
    alone = replace(robot, thrusters=robot.thrusters[1:])
    recording = recorded(alone, flight, 0)
    problem = momentum_problem(alone, recording, "unknown", lambda _: None)
    samples, late = problem.samples, delays(alone, recording, problem.late)
    sensors = sensors_of(alone, recording, late, samples.speeds)
    acting = problem_of(alone, problem.sets, samples, sensors).acting
    clock, (gain,) = acting.first, acting.recorded
    selected = np.array([clock, gain.place])
    beta = problem.sets.beta(alone.theta)
    table = acting.table(beta, np.array([0.0, -1.0]), selected)
    assert not table[..., 1].any()
    assert table[..., 2].any()
