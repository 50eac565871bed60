"""Gravity gradient and air drag on a flying arm, against MuJoCo with applied forces.

MuJoCo integrates every body. The tide on a body is that of its second moments: the
force on its mass elements is `T r dm`, `T = mu / R^3 (3 n n^T - 1)`, so the torque
about its CM is the antisymmetric part of `T E`, `E` the integral of `r r^T dm`.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import mujoco
import numpy as np
from mujoco_model import mujoco_model
from obvious_momentum import quaternion_rotation
from random_robots import random_robot, random_start, random_swing

from orbident.simulation.control_laws import JointPD
from orbident.simulation.flight import FlyingState, FreeFlying, standing
from orbident.simulation.free_flying import free_flying
from orbident.trajectories.environment import Environment

END, DT = 5.0, 0.01
ROBOT = replace(
    random_robot(3, (0, 1, 0), (2,), base=20.0),
    feature_point=np.array([0.3, -0.2, 0.1]),
)
SWING, JOINTS = random_swing(6, 3), JointPD(Kp=np.full(3, 20.0), Kd=np.full(3, 10.0))
CENTRE = np.array([0.5, 0.4, -0.2])
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


class Orbit:
    """Applies the tide and the air of an equatorial orbit at 400 km."""

    def __init__(self, model: mujoco.MjModel):
        self.bodies = [model.body(name).id for name in ROBOT.bodies]
        self.joints = np.array(
            [model.joint(name).dofadr[0] for name in ROBOT.joint_names]
        )

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        q, qd, _ = SWING.at(np.array([data.time]))
        e = q[0] - data.qpos[self.joints + 1]
        data.qfrc_applied[self.joints] = JOINTS.Kp * e
        data.qfrc_applied[self.joints] += JOINTS.Kd * (qd[0] - data.qvel[self.joints])
        R = 6778137.0
        mean = np.sqrt(3.986004418e14 / R**3)
        # What J2 does to the orbit in 5 s is 0.2 m.
        n = np.array([np.cos(mean * data.time), np.sin(mean * data.time), 0.0])
        T = mean**2 * (3 * np.outer(n, n) - np.eye(3))
        cm = data.subtree_com[self.bodies[0]]
        for body in self.bodies:
            force = model.body_mass[body] * T @ (data.xipos[body] - cm)
            axes = data.ximat[body].reshape(3, 3)
            moments = model.body_inertia[body]
            E = axes @ np.diag(moments.sum() / 2 - moments) @ axes.T
            A = T @ E
            torque = [A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]]
            data.xfrc_applied[body] = [*force, *torque]
        base = self.bodies[0]
        wind = (R * mean - 7.2921159e-5 * R) * np.array([-n[1], n[0], 0.0])
        drag = -0.5 * 3e-12 * 2.2 * 10.0 * np.linalg.norm(wind) * wind
        R_WB = data.xmat[base].reshape(3, 3)
        # Applied forces act at the body's CM.
        place = data.xpos[base] + R_WB @ (CENTRE - ROBOT.feature_point)
        data.xfrc_applied[base, :3] += drag
        data.xfrc_applied[base, 3:] += np.cross(place - data.xipos[base], drag)


def mujoco_end() -> tuple[np.ndarray, ...]:
    """Joints, attitude, base rate, position and velocity of S at the end."""
    state, model = start(), mujoco_model(ROBOT, ())
    model.opt.timestep = DT
    data = mujoco.MjData(model)
    orbit = Orbit(model)
    data.qpos[3:7] = np.roll(state.base.attitude, 1)
    data.qpos[orbit.joints + 1] = state.q
    data.qvel[:3] = state.base.velocity
    data.qvel[3:6] = state.base.angular_velocity
    data.qvel[orbit.joints] = state.qd
    mujoco.set_mjcb_control(orbit)
    try:
        for _ in range(round(END / DT)):
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_control(None)
    x, v = data.qpos, data.qvel
    R = quaternion_rotation(np.roll(x[3:7], -1))
    return x[orbit.joints + 1], R, v[3:6], x[:3], v[:3]


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
