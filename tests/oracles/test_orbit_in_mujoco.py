"""Gravity gradient and air drag on flying arms, against MuJoCo with applied forces.

MuJoCo integrates every body, and the orbit is by an integrator that is not ours. All
seeds, and a flight of a whole orbit: `pytest -m long -s` on this file.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from acting_in_mujoco import InOrbit, Stage
from leapfrog_orbit import flown_orbit, from_perigee_at_the_node
from mujoco_flights import Flight
from mujoco_model import mujoco_model
from obvious_momentum import quaternion_rotation
from random_robots import random_robot, random_start, random_swing

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.orbits.orbit import Elements, Orbit
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import AttitudeSpec
from orbident.simulation.flight import FlyingState, FreeFlying, JointPD, standing
from orbident.simulation.free_flying import free_flying
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory

END, DT = 5.0, 0.01
ROBOT = replace(
    random_robot(3, (0, 1, 0), (2,), base=20.0),
    feature_point=np.array([0.3, -0.2, 0.1]),
)
SWING, JOINTS = random_swing(6, 3), JointPD(Kp=np.full(3, 20.0), Kd=np.full(3, 10.0))
CENTRE = np.array([0.5, 0.4, -0.2])
RADIUS = 6778137.0
DRAG = 0.5 * 3e-12 * 2.2 * 10.0
AIR = {"density": 3e-12, "area": 10.0, "centre": CENTRE.tolist()}
GIVEN = {
    "orbit": {"altitude": "400 km", "inclination": 0},
    "gravity_gradient": True,
    "air_drag": AIR,
}


def start() -> FlyingState:
    q, qd, _ = SWING.at(np.zeros(1))
    return standing(random_start(8, ROBOT), q[0])._replace(qd=qd[0])


def flown(given: dict) -> FreeFlying:
    t = np.linspace(0.0, END, 26)
    environment = Environment.model_validate(given)
    state, options = start(), {"tolerance": 1e-10, "environment": environment}
    return free_flying(ROBOT, t, state, SWING, JOINTS, **options)


class Law:
    """Drives the joints as ours does, in the tide and the air of an orbit."""

    def __init__(self, model: mujoco.MjModel):
        orbit = flown_orbit(from_perigee_at_the_node(RADIUS, 0.0, 0.0), END)
        self.orbit = InOrbit(orbit, DRAG, CENTRE - ROBOT.feature_point)
        self.joints = np.array(
            [model.joint(name).dofadr[0] for name in ROBOT.joint_names]
        )

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        q, qd, _ = SWING.at(np.array([data.time]))
        e = q[0] - data.qpos[self.joints + 1]
        data.qfrc_applied[:] = 0.0
        self.orbit(Stage(model, data, data.time), data.qfrc_applied)
        data.qfrc_applied[self.joints] += JOINTS.Kp * e
        data.qfrc_applied[self.joints] += JOINTS.Kd * (qd[0] - data.qvel[self.joints])


def mujoco_end() -> tuple[np.ndarray, ...]:
    """Joints, attitude, base rate, position and velocity of S at the end."""
    state, model = start(), mujoco_model(ROBOT, ())
    model.opt.timestep = DT
    data = mujoco.MjData(model)
    law = Law(model)
    data.qpos[3:7] = np.roll(state.base.attitude, 1)
    data.qpos[law.joints + 1] = state.q
    data.qvel[:3] = state.base.velocity
    data.qvel[3:6] = state.base.angular_velocity
    data.qvel[law.joints] = state.qd
    mujoco.set_mjcb_control(law)
    try:
        for _ in range(round(END / DT)):
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_control(None)
    x, v = data.qpos, data.qvel
    R = quaternion_rotation(np.roll(x[3:7], -1))
    return x[law.joints + 1], R, v[3:6], x[:3], v[:3]


def test_an_arm_in_orbit_ends_where_mujoco_says():
    ours, alone = (flown(given) for given in (GIVEN, {}))

    def end(flight: FreeFlying) -> list[np.ndarray]:
        R = quaternion_rotation(flight.attitude[-1])
        return [flight.q[-1], R, flight.w[-1], flight.r_S[-1], flight.v_S[-1]]

    for name, theirs, mine, without in zip(
        ("q", "attitude", "w", "r_S", "v_S"),
        mujoco_end(),
        end(ours),
        end(alone),
        strict=True,
    ):
        moved = np.abs(mine - without).max()
        # MuJoCo's RK4 at 10 ms: 4e-9 rad/s after 2 s of another robot.
        assert np.abs(theirs - mine).max() < 3e-8, name
        assert moved > 1e-6, name


TALL = 6800e3, 0.003, np.radians(51.6)
"""Semi-major axis, m, eccentricity and inclination of the servicer's orbit: 400 km."""

WHOLE = 5550.0
"""s: once around the Earth."""

MANY, SEVERAL = 20, 30
"""Runs with other noise; those of a whole orbit take some twenty minutes."""


@cache
def servicer() -> Robot:
    """The paper's, with a star tracker."""
    robot = spatial_robot()
    sensors = robot.sensors.model_copy(update={"attitude": AttitudeSpec(angle=1.7e-5)})
    a, e, inclination = TALL
    return replace(robot, sensors=sensors, orbit=Orbit(Elements(a, inclination, e)))


@cache
def short_flight() -> Flight:
    """The paper's trajectory."""
    return in_orbit(servicer(), spatial_trajectory(servicer()), 0.05)


@cache
def long_flight() -> Flight:
    """Once around the Earth, the joints waving with periods of one to three minutes."""
    sensors = servicer().sensors.model_copy(update={"rate": 1.0})
    robot = replace(servicer(), sensors=sensors)
    motion = spatial_trajectory(robot)
    a, b = np.zeros((2, len(robot.joints), 90))
    for k in range(len(robot.joints)):
        a[k, [30 + 7 * k, 61 - 5 * k]] = 0.02, -0.03
        b[k, [45 + 3 * k, 80 - 11 * k]] = 0.03, 0.02
    # The series begins and ends as it goes on: nothing else is added to it.
    w = 2 * np.pi * np.arange(1, 91) / WHOLE
    ends = np.stack([-(b / w).sum(axis=1), a.sum(axis=1), b @ w], axis=1)
    initial = replace(
        motion.initial,
        angular_velocity=np.array([0.004, -0.003, 0.005]),
        wheel_speed=dict.fromkeys(robot.wheel_names, 40.0),
    )
    motion = replace(
        motion, duration=WHOLE, a=a, b=b, start=ends, end=ends, initial=initial
    )
    # Steps of 0.125 s would turn the base by 6e-6 rad, and all samples of a whole orbit
    # show its attitude to 1e-6 rad; half of them leaves a sixteenth.
    return in_orbit(robot, motion, 0.0625)


def in_orbit(robot: Robot, motion: Trajectory, dt: float) -> Flight:
    orbit = flown_orbit(from_perigee_at_the_node(*TALL), motion.duration)
    acts = InOrbit(orbit, DRAG, CENTRE - robot.feature_point)
    return Flight(robot, motion, acts, dt=dt)


def off(result: Result, robot: Robot) -> np.ndarray:
    """Errors of the base parameters in their deviations."""
    true = minimal_sets(robot).beta(robot.theta)
    return (result.base.values - true) / result.base.std


@pytest.mark.parametrize(
    ("flight", "runs"),
    [
        pytest.param(short_flight, 1, marks=pytest.mark.slow),
        pytest.param(short_flight, MANY, marks=pytest.mark.long),
        pytest.param(long_flight, SEVERAL, marks=pytest.mark.long),
    ],
    ids=["one", "many", "whole orbit"],
)
def test_a_servicer_in_orbit_is_identified(flight, runs: int):
    """95 % intervals hold what they say; its robot file gives the orbit."""
    z, groups = [], []
    for seed in range(runs):
        result = identify(flight().robot, flight().recorded(seed))
        assert result.status == "ok", result.warnings
        groups.append({fit.group for fit in result.disturbances.values()})
        z.append(off(result, flight().robot))
        print(seed, groups[-1], np.abs(z[-1]).max().round(2))
    inside = np.mean(np.abs(z) < 1.96)
    print(
        f"{inside:.3f} of {np.size(z)} inside, rms {np.sqrt(np.mean(np.square(z))):.2f}"
    )
    # Either the air is found, or what it does is taken for a torque.
    assert all(groups)
    assert np.abs(z).max() < 4
    # Errors of a run go together: of 20 runs chance moves the part inside by 3 %.
    assert runs < MANY or inside > 0.9


@pytest.mark.parametrize(
    ("flight", "runs"),
    [
        pytest.param(short_flight, 1, marks=pytest.mark.slow),
        pytest.param(short_flight, MANY, marks=pytest.mark.long),
        pytest.param(long_flight, 1, marks=pytest.mark.long),
    ],
    ids=["one", "many", "whole orbit"],
)
def test_without_the_orbit_nothing_is_wrong(flight, runs: int):
    """It is refused, or a torque is named and what is identified holds."""
    robot = replace(flight().robot, orbit=None)
    for seed in range(runs):
        result = identify(robot, flight().recorded(seed))
        groups = {fit.group for fit in result.disturbances.values()}
        print(seed, result.status, groups, result.warnings[:1])
        if result.status == "ok":
            # What wheels lose may explain it too: then the torque is named beside it.
            assert any("a torque acts" in words for words in result.warnings)
            assert np.abs(off(result, robot)).max() < 5
