"""Motors' rotors that are bodies in MuJoCo, each turning so often as its gear says.

The constraint between a joint and its rotor is met by `v = T v'`, with MuJoCo's own
mass matrix and bias; in flights, by what acts between the two.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from acting_in_mujoco import Torque
from mujoco_flights import Flight
from mujoco_model import mujoco_model, rotor_name
from random_motions import random_motion
from random_robots import random_robot, random_wheels, sensors_in_space
from seventeen_flights import SPEED, robot_of

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.equations_of_motion import equations_of_motion, velocity_of_S
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import GearedRotor, Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.free_floating import BaseState, free_floating

ROUNDING = 1e-12
"""Of sums of some tens of products, over the largest entry."""

SAME_RATE = 1e-8
"""rad/s: MuJoCo's steps of 0.01 s leave 1e-9; without rotors 5e-5 are off."""

TOLERANCE = 0.2
"""So well rotors are known."""

SEEDS = 60

TORQUE = {"paper-spatial": 0.1, "random": 0.02}
"""Noise of torque sensors, N m."""

NOTHING = Torque(np.zeros(3))


def with_rotors(robot: Robot, seed: int) -> Robot:
    """Rotors of 1e-6 to 1e-3 kg m^2 behind gears of 50 to 160, some against."""
    random = np.random.default_rng(seed)
    rotors = {
        joint.name: GearedRotor(
            float(random.choice([-1, 1]) * random.uniform(50, 160)),
            float(10 ** random.uniform(-6, -3)),
            TOLERANCE,
        )
        for joint in robot.joints
        if joint.kind == "revolute"
    }
    return replace(robot, rotors=rotors)


@pytest.mark.parametrize("seed", range(3))
def test_equations_of_motion(seed):
    wheels = random_wheels(seed, ("held",) * 2)
    slides = (3,) if seed == 2 else ()
    # A heavy base, from which wheels and rotors can be taken.
    robot = random_robot(seed, (0, 1, 1, 3), slides, wheels, base=20.0)
    robot = with_rotors(robot, seed)
    random, n = np.random.default_rng(seed), len(robot.joints)
    q, v = random.standard_normal(n), random.standard_normal(6 + n + len(wheels))
    model = mujoco_model(robot, np.zeros((len(wheels), 3)))
    data = mujoco.MjData(model)
    # The base stands at the origin: its axes are inertial ones.
    T = np.zeros((model.nv, v.size))
    T[:6, :6] = np.eye(6)
    T[:3] = velocity_of_S(robot, q)[:3]
    for k, name in enumerate((*robot.joint_names, *robot.wheel_names)):
        T[model.joint(name).dofadr[0], 6 + k] = 1.0
    for k, name in enumerate(robot.joint_names):
        data.qpos[model.joint(name).qposadr[0]] = q[k]
        if name in robot.rotors:
            dof = model.joint(rotor_name(name)).dofadr[0]
            T[dof, 6 + k] = robot.rotors[name].gear
    data.qvel[:] = T @ v
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    H, c, f_S = (x[0] for x in equations_of_motion(robot, q[None], v[None]))
    drift = np.zeros(model.nv)
    drift[:3] = f_S
    for ours, theirs in ((H, T.T @ M @ T), (c, T.T @ (M @ drift + data.qfrc_bias))):
        scale = np.abs(theirs).max()
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=10 * ROUNDING * scale)


def test_simulated_as_mujoco_flies_them():
    """The base floats as it does in MuJoCo; without the rotors it would not."""
    robot = with_rotors(random_robot(5, (0, 1), base=20.0), 5)
    robot = replace(robot, sensors=declared_sensors({"rate": 10.0}))
    motion = random_motion(robot, 5, 10.0, SPEED, "turning")
    t, true = Flight(robot, motion, NOTHING).flown
    start = BaseState(true.gyro[0], true.attitude[0], np.zeros(3), np.zeros(0))
    for plant, expected in ((robot, True), (replace(robot, rotors={}), False)):
        ours = free_floating(plant, motion.for_robot(robot).motion, t, start, 1e-10)
        assert (np.abs(ours.w - true.gyro).max() < SAME_RATE) == expected


def flown_robot(name: str, torques: bool = False) -> Robot:
    """One whose structure is known, and one of any bodies; nothing acts on them."""
    robot = load_robot("paper-spatial") if name == "paper-spatial" else robot_of(4)
    sensors = sensors_in_space(np.random.default_rng(1))
    if torques:
        sensors |= {"torques": {"std": TORQUE[name]}}
    return replace(robot, sensors=declared_sensors(sensors), disturbances={})


class Found(NamedTuple):
    """What was identified of a flight, off from the truth in its deviations."""

    base: np.ndarray
    links: np.ndarray
    H: np.ndarray
    """The joints' own entries of `H+`."""
    armature: np.ndarray
    """`N (N - 1) J` of what torques show; nothing without torques."""
    of_H: float
    """How far the joints' block of `H+` is off, over its diagonal."""


def found(
    name: str, seed: int, declared: bool, torques: bool = False
) -> tuple[Result, Found]:
    """Identify a flight; what is declared of rotors is as wrong as it may be."""
    random = np.random.default_rng(seed)
    said = with_rotors(flown_robot(name, torques), seed)
    # A rotor has more than nothing.
    off = np.maximum(0.05, 1 + TOLERANCE * random.standard_normal(len(said.joints)))
    rotors = {
        each: rotor._replace(inertia=off[k] * rotor.inertia)
        for k, (each, rotor) in enumerate(said.rotors.items())
    }
    plant = replace(said, rotors=rotors)
    motion = random_motion(plant, seed, 60.0, SPEED, "turning")
    recording = Flight(plant, motion, NOTHING).recorded(seed)
    cad = 1 + 0.1 * random.uniform(-1, 1, (len(said.bodies), 1))
    beforehand = {
        each: TOLERANCE * armature_of(rotor) if declared else np.inf
        for each, rotor in said.rotors.items()
    }
    known = replace(
        said,
        theta=cad * said.theta,
        rotors=said.rotors if declared else {},
        tolerances=replace(said.tolerances, joint_armature=beforehand),
    )
    result, sets = identify(known, recording), minimal_sets(plant)
    base = (result.base.values - sets.beta(plant.theta)) / result.base.std
    links, n = result.links, len(plant.joints)
    own = dict(zip(result.base.names, sets.base.T @ plant.theta.ravel(), strict=True))
    alone = links.values - [own[each] for each in links.names]
    q, model = np.zeros(n), result.dynamics()
    v = np.zeros(6 + n + len(plant.wheels))
    H = equations_of_motion(plant, q[None], v[None]).H[0]
    joints = slice(6, 6 + n)
    wrong = (model.H_plus(q) - H)[joints, joints]
    own_H = np.diag(wrong) / np.diag(model.H_plus_std(q))[joints]
    size = np.sqrt(np.diag(H)[joints])
    armature = [
        (result.drives[each].armature - armature_of(rotor))
        / result.drives[each].armature_std
        for each, rotor in plant.rotors.items()
        if each in result.drives
    ]
    of_H = float(np.abs(wrong / np.outer(size, size)).max())
    return result, Found(base, alone / links.std, own_H, np.array(armature), of_H)


def armature_of(rotor: GearedRotor) -> float:
    """What the joint's own entry of `H+` has beside what momentum shows, kg m^2."""
    return rotor.gear * (rotor.gear - 1) * rotor.inertia


FAR = 4.0
"""Deviations that chance does not reach among some hundred numbers."""


@pytest.mark.parametrize(
    "name", ["paper-spatial", pytest.param("random", marks=pytest.mark.slow)]
)
def test_identified_with_declared_rotors(name):
    result, off = found(name, 1, declared=True)
    assert result.level == "trust"
    assert max(np.abs(each).max() for each in off[:3]) < FAR


@pytest.mark.slow
def test_identified_without_a_word_of_rotors():
    """What is printed is named so and holds; only what `H+` lacks is off, and said."""
    result, off = found("random", 1, declared=False)
    assert result.level == "trust"
    assert np.abs(off.base).max() < FAR
    assert np.abs(off.H).max() > FAR
    assert any("rotor(joint1)" in formula for formula in result.base.formulas)
    assert "motors' rotors are not in the inertia of 'joint1'" in repr(
        result.dynamics()
    )


def inside(every: list[Found], part: str) -> float:
    """The part of all numbers within their 95 % intervals, which it prints."""
    off = np.concatenate([getattr(one, part) for one in every])
    held = float(np.mean(np.abs(off) < 1.96))
    print(f"{part}: {100 * held:.1f} % of {off.size}, worst {np.abs(off).max():.1f}")
    return held


@pytest.mark.long
@pytest.mark.parametrize("name", ["paper-spatial", "random"])
def test_intervals_hold(name):
    """Of 60 flights: base parameters, links alone, and the joints' entries of `H+`."""
    every = [found(name, seed, declared=True)[1] for seed in range(SEEDS)]
    for part in ("base", "links", "H"):
        # Numbers of one flight are correlated: of 60 the part varies by 1 to 2 %.
        assert inside(every, part) == pytest.approx(0.95, abs=0.05)


@pytest.mark.long
@pytest.mark.parametrize("declared", [True, False])
@pytest.mark.parametrize("name", ["paper-spatial", "random"])
def test_torques_show_the_rotors(name, declared):
    """Of 20 flights: with a gear that is known, `J` follows, and `H+` is right to 1 %.

    Where nothing is said of rotors, `N (N - 1) J` follows.
    """
    every = [found(name, seed, declared, torques=True)[1] for seed in range(20)]
    for part in ("base", "H", "armature"):
        assert inside(every, part) == pytest.approx(0.95, abs=0.05)
    worst = max(one.of_H for one in every)
    print(f"H+ off by {100 * worst:.2f} % at most")
    # What is asked for where gears are known.
    assert worst < 0.01 or not declared
