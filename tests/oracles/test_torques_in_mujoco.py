"""Torques that MuJoCo applies at joints, as equations and as sensors.

The equation in momentum form (theory: Section 6) is met on exact data by MuJoCo's own
torques and motion, and by the simulator's inverse dynamics. What is identified of
MuJoCo's flights holds, without any wheel too.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest
from acting_in_mujoco import Swell, Torque
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import sensors_in_space
from scipy.interpolate import CubicSpline
from seventeen_flights import SPEED, robot_of

from orbident import _core
from orbident.choices import Method
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.core_robot import core_tree
from orbident.model.equations_of_motion import equations_of_motion
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Friction, GearedRotor, Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import TORQUE_CONSTANTS, TORQUE_SENSORS
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.simulation.measure import Truth, truth_of

NOTHING = Torque(np.zeros(3))
FRICTION = Friction(0.1, 0.05, 0.02)
"""Of every joint: N m s, N m and N m."""

LIBRARY = Path(str(files("orbident.robot") / "library"))

SLOW = 0.01
"""N m: about each axis, changing once in 150 s."""

CONSTANT = 2.0
"""N m/A: torque constants as the robot file has them."""

FAR = 4.5
"""Deviations beyond which none of some fifty correlated numbers is."""


def check_equation(robot: Robot, t: np.ndarray, true: Truth) -> None:
    """`p(t) - p(0)` is the integral of `dT/dq + tau`."""
    joints, theta = len(robot.joints), np.tile(robot.theta.ravel(), (t.size, 1))
    table = _core.joint_momenta(
        core_tree(robot), np.eye(theta.shape[1]), theta, true.q, true.qd, true.gyro
    )[:, 3:, 0]
    p, e = table[:, :joints], table[:, joints:]
    assert true.tau is not None
    gained = CubicSpline(t, e + true.tau).antiderivative()(t)
    # Of a spline with 20 rows a second: torques turn at some rad/s.
    scale = np.abs(p).max(axis=0)
    assert (np.abs(p - p[0] - gained) < 1e-6 * scale).all()


def test_the_equation_holds_of_exact_data():
    robot = replace(load_robot("paper-spatial"), sensors=declared_sensors({"rate": 20}))
    motion = random_motion(robot, 3, 20.0, SPEED, "turning")
    t, true = Flight(robot, motion, NOTHING).flown
    check_equation(robot, t, true)
    own = motion.for_robot(robot).motion
    start = BaseState(true.gyro[0], true.attitude[0], np.zeros(3), true.qd_rw[0])
    ours = truth_of(robot, free_floating(robot, own, t, start, 1e-10), own)
    check_equation(robot, t, ours)
    assert ours.tau is not None
    assert true.tau is not None
    # MuJoCo's steps of 0.01 s.
    scale = np.abs(true.tau).max()
    np.testing.assert_allclose(ours.tau, true.tau, atol=1e-5 * scale)


def flown_robot(wheels: bool = False) -> Robot:
    """One of any bodies, whose joints have friction and torque sensors."""
    robot = robot_of(4)
    sensors = sensors_in_space(np.random.default_rng(1)) | {"torques": {"std": 0.02}}
    anything = dict.fromkeys(robot.joint_names, np.inf)
    return replace(
        robot,
        sensors=declared_sensors(sensors),
        wheels=robot.wheels if wheels else (),
        disturbances={},
        friction=dict.fromkeys(robot.joint_names, FRICTION),
        tolerances=replace(
            robot.tolerances,
            joint_viscous=anything,
            joint_coulomb=anything,
            joint_torque_offset=anything,
        ),
    )


class Found(NamedTuple):
    """What was identified, off from the truth in its deviations."""

    result: Result
    base: np.ndarray
    friction: np.ndarray
    armature: np.ndarray


def found(
    plant: Robot,
    seed: int,
    declared: bool = True,
    scales: Mapping[str, float] = MappingProxyType({}),
) -> Found:
    """Identify a flight with a CAD model that is off by 10 %, and unknown friction.

    Args:
        plant: what flies.
        seed: of the flight.
        declared: whether the robot file has the rotors, which are 30 % off there.
        scales: what torque sensors show too much, relative, by joint.
    """
    random = np.random.default_rng(seed)
    motion = random_motion(plant, seed, 60.0, SPEED, "turning")
    recording = Flight(plant, motion, NOTHING).recorded(seed)
    shown = {f"joint.{name}.torque": 1 + off for name, off in scales.items()}
    recording = recording.with_columns(
        {name: scale * recording.column(name) for name, scale in shown.items()}
    )
    cad = 1 + 0.1 * random.uniform(-1, 1, (len(plant.bodies), 1))
    # Of rotors the gear is known, and their inertia to a half.
    rotors = {
        name: rotor._replace(inertia=1.3 * rotor.inertia)
        for name, rotor in plant.rotors.items()
    }
    known = replace(
        plant,
        theta=cad * plant.theta,
        friction={},
        rotors=rotors if declared else {},
        torque_constants=dict.fromkeys(plant.torque_constants, CONSTANT),
    )
    result = identify(known, recording)
    beta = minimal_sets(plant).beta(plant.theta)
    friction, armature = [], []
    for name, fit in result.drives.items():
        numbers = np.array(fit[2:]).reshape(3, 2)
        friction += [*((numbers[:, 0] - FRICTION[:3]) / numbers[:, 1])]
        rotor = plant.rotors.get(name)
        if rotor is not None:
            A = rotor.gear * (rotor.gear - 1) * rotor.inertia
            armature.append((fit.armature - A) / fit.armature_std)
    base = (result.base.values - beta) / result.base.std
    return Found(result, base, np.array(friction), np.array(armature))


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_identified_without_a_wheel(seed):
    """Torques alone say how large everything is."""
    result, base, friction, _ = found(flown_robot(), seed)
    assert result.level == "trust"
    assert result.mass.std < 0.002 * result.mass.value
    assert np.abs(np.concatenate([base, friction])).max() < FAR


@pytest.mark.slow
@pytest.mark.parametrize(("declared", "std"), [(True, 0.5), (False, np.inf)])
def test_rotors_follow_from_torques(declared, std):
    """`N (N - 1) J`, of which the robot file knows a half, or nothing."""
    robot = flown_robot(wheels=True)
    rotors = {name: GearedRotor(100.0, 1e-4, 0.5) for name in robot.joint_names}
    armature = dict.fromkeys(robot.joint_names, std * 1.3 * 0.99)
    tolerances = replace(robot.tolerances, joint_armature=armature)
    plant = replace(robot, rotors=rotors, tolerances=tolerances)
    result, base, friction, off = found(plant, 1, declared)
    assert result.status == "ok"
    assert off.size == len(robot.joints)
    if not declared:
        assert "motors' rotors are not in" not in repr(result.dynamics())
    assert np.abs(np.concatenate([base, friction, off])).max() < FAR
    for fit in result.drives.values():
        assert fit.armature_std < 0.03 * fit.armature
    # A tolerance of a half would leave half of the joints' own entries of `H+`.
    q, joints = np.zeros(len(robot.joints)), slice(6, 6 + len(robot.joints))
    model = result.dynamics()
    v = np.zeros(6 + q.size + len(robot.wheels))
    H = equations_of_motion(plant, q[None], v[None]).H[0]
    std = np.diag(model.H_plus_std(q))[joints]
    error = np.diag(model.H_plus(q) - H)[joints]
    assert (np.abs(error) < FAR * std).all()
    assert (std < 0.03 * np.diag(H)[joints]).all()


def by_other(method: Method, seed: int) -> tuple[Result, np.ndarray]:
    """What another method makes of a flight with wheels and torques."""
    plant = flown_robot(wheels=True)
    recording = Flight(
        plant, random_motion(plant, seed, 60.0, SPEED, "turning"), NOTHING
    ).recorded(seed)
    random = np.random.default_rng(seed)
    cad = 1 + 0.1 * random.uniform(-1, 1, (len(plant.bodies), 1))
    known = replace(plant, theta=cad * plant.theta, friction={})
    result = identify(known, recording, method=method)
    beta = minimal_sets(plant).beta(plant.theta)
    return result, (result.base.values - beta) / result.base.std


@pytest.mark.parametrize("method", ["structured", "recursive"])
def test_identified_by_other_methods(method):
    """Torques are equations of theirs too."""
    result, base = by_other(method, 0)
    assert result.status == "ok"
    assert not any("torques" in note for note in result.notes)
    assert np.abs(base).max() < FAR


@pytest.mark.long
@pytest.mark.parametrize("method", ["structured", "recursive"])
def test_intervals_of_other_methods_hold(method):
    """In 20 flights with wheels 95 % of the base parameters are in their intervals."""
    off = np.concatenate([by_other(method, seed)[1] for seed in range(20)])
    assert np.mean(np.abs(off) < 1.96) == pytest.approx(0.95, abs=0.05)


@pytest.mark.long
def test_intervals_hold():
    """Of 20 flights without a wheel: base parameters and friction."""
    every = [found(flown_robot(), seed)[1:3] for seed in range(20)]
    for off in map(np.concatenate, zip(*every, strict=True)):
        held = np.mean(np.abs(off) < 1.96)
        # Numbers of one flight are correlated: of 20, hundreds count as about 100.
        assert held == pytest.approx(0.95, abs=0.05), held


def found_off(wheels: bool, motors: bool, seed: int) -> tuple[Found, np.ndarray]:
    """What is identified where all torques are shown too large or too small.

    Args:
        wheels: whether the robot has any, which give the scale as well.
        motors: whether currents show torques, or sensors.
        seed: of the flight, and of what is off.

    Returns:
        Beside it how far off the errors of scale are, in their deviations.
    """
    robot = flown_robot(wheels)
    names, std = robot.joint_names, TORQUE_CONSTANTS if motors else TORQUE_SENSORS
    off = std * np.random.default_rng(100 + seed).standard_normal(len(names))
    scales = dict(zip(names, off.tolist(), strict=True))
    known = replace(robot.tolerances, joint_torque_scale=dict.fromkeys(names, std))
    plant = replace(robot, tolerances=known)
    if motors:
        # What the robot file makes of a current is CONSTANT / constant of the torque.
        constants = {name: CONSTANT / (1 + scale) for name, scale in scales.items()}
        one = found(replace(plant, torque_constants=constants), seed)
    else:
        one = found(plant, seed, scales=scales)
    fits = [one.result.calibration[f"joint.{name}.torque_scale"] for name in names]
    errors = [(fit.value - e) / fit.std for fit, e in zip(fits, off, strict=True)]
    return one, np.array(errors)


@pytest.mark.parametrize(
    ("wheels", "mass"),
    [pytest.param(True, 5e-4, marks=pytest.mark.slow), (False, 0.03)],
)
def test_identified_by_currents(wheels, mass):
    """Torque constants are off by 5 %, and wheels calibrate them."""
    one, scales = found_off(wheels, True, 0)
    M = one.result.mass
    assert one.result.level == "trust"
    assert M.std < mass * M.value
    assert np.abs(np.concatenate([one.base, one.friction, scales])).max() < FAR


@pytest.mark.long
@pytest.mark.parametrize(("wheels", "within"), [(True, 0.02), (False, 0.05)])
@pytest.mark.parametrize("motors", [True, False])
def test_intervals_hold_where_torques_are_off(motors, wheels, within):
    """Base parameters, friction and scales of 80 flights are in 95 % intervals.

    The part of 400 numbers that is inside varies by 1.1 %, of 100 by 2.2 %. Without
    wheels all numbers of a flight share the error of its scale: of 80 it is 2.4 %.
    """
    every = [found_off(wheels, motors, seed) for seed in range(80)]
    numbers = ((one.base, one.friction, scales) for one, scales in every)
    for off in map(np.concatenate, zip(*numbers, strict=True)):
        held = np.mean(np.abs(off) < 1.96)
        assert held == pytest.approx(0.95, abs=within), held


class World(NamedTuple):
    """What is compared: sensors, what acts, and what is known."""

    speed: float
    """Of the wheels, rad/s; zero of a robot without any."""
    torques: bool
    scale: float
    """Standard deviation of the torque sensors' scales, relative."""
    acts: bool
    """Whether a slow torque acts from outside; then it is among the unknowns."""

    def robot(self) -> Robot:
        """The paper's servicer with a star tracker, a camera and torque sensors."""
        document = dict(load_robot("paper-spatial").document)
        document["urdf"] = str(LIBRARY / "paper-spatial.urdf")
        document["sensors"] |= {
            "attitude": {"angle": "10 arcsec"},
            "position": {"std": "1 mm"},
            "torques": {"std": "0.1 N m"},
        }
        document["disturbances"] = ["slow_torque"] if self.acts else []
        if not self.speed:
            document["wheels"] = []
            document["sensors"].pop("wheels")
        robot = load_robot(document)
        scales = dict.fromkeys(robot.joint_names, self.scale)
        return replace(
            robot,
            friction=dict.fromkeys(robot.joint_names, FRICTION),
            tolerances=replace(robot.tolerances, joint_torque_scale=scales),
        )

    def recorded(self, seed: int) -> Recording:
        """One flight, with torques as wrong as their scales may be, or without."""
        recording = flown(self._replace(torques=True, scale=0.0), seed)
        columns = dict(recording.columns)
        random = np.random.default_rng(seed)
        for name in self.robot().joint_names:
            shown = 1 + self.scale * random.standard_normal()
            torque = columns.pop(f"joint.{name}.torque")
            if self.torques:
                columns[f"joint.{name}.torque"] = shown * torque
        return replace(recording, columns=columns)

    def found(self, seed: int) -> tuple[Result, np.ndarray]:
        """What is identified by a wrong CAD model, and how far off it is."""
        plant, random = self.robot(), np.random.default_rng(seed)
        cad = 1 + 0.1 * random.uniform(-1, 1, (len(plant.bodies), 1))
        known = replace(plant, theta=cad * plant.theta, friction={})
        result = identify(known, self.recorded(seed))
        beta = minimal_sets(plant).beta(plant.theta)
        return result, (result.base.values - beta) / result.base.std


@cache
def flown(world: World, seed: int) -> Recording:
    """MuJoCo's flight of the robot of a world."""
    robot, random = world.robot(), np.random.default_rng(seed)
    motion = random_motion(robot, seed, 60.0, world.speed, "turning")
    swell = Swell(SLOW * random.standard_normal(3), 150.0, random.uniform(0, 6))
    return Flight(robot, motion, swell if world.acts else NOTHING).recorded(seed)


COMPARED = (
    *((SPEED, False, 0.0), (SPEED / 10, False, 0.0)),
    *((0.0, True, 0.0), (SPEED / 10, True, 0.0), (SPEED, True, 0.0)),
    *((0.0, True, 0.01), (SPEED / 10, True, 0.01), (SPEED, True, 0.01)),
)
"""Wheels, torques and their scales: momentum alone, torque alone, and both."""


def main(seeds: int) -> None:
    """Which is more accurate, momentum or torque (Rackl 2013)? A table."""
    for acts in (False, True):
        for compared in COMPARED:
            world = World(*compared, acts)
            every = [world.found(seed) for seed in range(seeds)]
            # What is refused has no numbers.
            kept = [each for each in every if each[0].status == "ok"]
            std = np.array([result.base.std for result, _ in kept])
            off = np.concatenate([off for _, off in kept])
            trusted = sum(result.level == "trust" for result, _ in every)
            print(
                f"wheels {world.speed:g} rad/s, torques {world.torques} within "
                f"{world.scale:g}, slow torque {acts}: M +- {np.mean(std[:, 0]):.3g} "
                f"kg, base parameters +- {np.exp(np.mean(np.log(std))):.3g} (mean), "
                f"{100 * np.mean(np.abs(off) < 1.96):.1f} % of intervals hold, rms "
                f"{np.sqrt(np.mean(off**2)):.2f}, {trusted} of {seeds} trusted",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]))
