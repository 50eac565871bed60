"""A panel that nobody measures, flown by MuJoCo: what is identified of it holds."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from mujoco_model import mujoco_model

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.model.springs import carried_inertia
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.measure import Truth, measure_truth

FILE = """\
schema: orbident/robot/1
urdf: sat.urdf
wheels:
  - {name: w1, axis: [1, 0, 0], inertia: 0.05}
  - {name: w2, axis: [0, 1, 0], inertia: 0.05}
  - {name: w3, axis: [0, 0, 1], inertia: 0.05}
passive: {panel: {frequency: 0.5 Hz, damping: 0.5 %}}
disturbances: []
tolerances: exact
sensors:
  rate: 20 Hz
  gyro: {angle_random_walk: 0.02 deg/sqrt(h)}
  attitude: {angle: 0.005 deg}
  position: {std: 1 mm}
  joints: {position: 5e-5 rad}
  wheels: {tachometer: 0.01 rad/s}
"""

LINKS = {
    "base": ("0.03 0 0.05", 120, "14 16 13"),
    "upper": ("0 0.01 0.375", 10, "0.5 0.5 0.05"),
    "lower": ("0.02 0 0.3", 8, "0.3 0.3 0.05"),
    "sheet": ("0 0.9 0", 8, "2.3 0.3 2.5"),
}
JOINTS = {
    "shoulder": ("base", "upper", "0.3 0 0.6", "1 0 0"),
    "elbow": ("upper", "lower", "0 0 0.75", "0 1 0"),
    "panel": ("base", "sheet", "0 0.5 0", "1 0 0"),
}

STEP, EVERY, DURATION = 0.005, 10, 40.0
"""s; steps from row to row; s."""

SPIN = np.array([150.0, -120.0, 100.0])
"""Of the wheels at the start, rad/s."""


def urdf() -> str:
    parts = []
    for name, (com, mass, diagonal) in LINKS.items():
        xx, yy, zz = diagonal.split()
        parts.append(
            f'<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
            "</inertial></link>"
        )
    for name, (parent, child, at, axis) in JOINTS.items():
        parts.append(
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{at}"/><axis xyz="{axis}"/></joint>'
        )
    return f'<robot name="sat">{"".join(parts)}</robot>'


def commanded(t: float) -> np.ndarray:
    """Accelerations of shoulder, elbow and wheels, rad/s^2."""
    arm = [0.3 * np.sin(0.9 * t), 0.4 * np.sin(1.7 * t)]
    return np.array([*arm, *(-0.05 * SPIN * np.sin(0.3 * t))])


def flown(robot: Robot) -> tuple[np.ndarray, Truth]:
    """By torques that give joints and wheels the accelerations that are commanded."""
    places = [np.array([0.05, 0.02, 0.01]) * (k + 1) for k in range(3)]
    model = mujoco_model(robot, places)
    model.opt.timestep = STEP
    inertia = carried_inertia(robot, 2) @ robot.theta.ravel()
    rate, share = 2 * np.pi * robot.passive["panel"].frequency, 0.005
    model.joint("panel").stiffness[...] = rate**2 * inertia
    model.dof_damping[model.joint("panel").dofadr[0]] = 2 * share * rate * inertia
    data = mujoco.MjData(model)
    names = ("shoulder", "elbow", *robot.wheel_names)
    driven = [int(model.joint(name).dofadr[0]) for name in names]
    free = [k for k in range(model.nv) if k not in driven]
    data.qvel[driven[2:]] = SPIN
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))

    def control(_: mujoco.MjModel, at: mujoco.MjData) -> None:
        mujoco.mj_fullM(model, at, mass)
        acceleration = np.zeros(model.nv)
        acceleration[driven] = commanded(at.time)
        force = at.qfrc_passive - at.qfrc_bias
        others = mass[np.ix_(free, driven)] @ acceleration[driven]
        acceleration[free] = np.linalg.solve(
            mass[np.ix_(free, free)], force[free] - others
        )
        at.qfrc_applied[driven] = (mass @ acceleration - force)[driven]

    rows = []

    def keep() -> None:
        q, qd = (
            np.array([x[int(getattr(model.joint(name), at)[0])] for name in all_joints])
            for x, at in ((data.qpos, "qposadr"), (data.qvel, "dofadr"))
        )
        rows.append((data.time, q, qd, data.qvel[:6].copy(), data.qpos[:7].copy()))

    all_joints = (*robot.joint_names, *robot.wheel_names)

    mujoco.set_mjcb_control(control)
    try:
        for k in range(round(DURATION / STEP) + 1):
            if k % EVERY == 0:
                keep()
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_control(None)
    t, q, qd, v, x = (np.array(column) for column in zip(*rows, strict=True))
    return t, Truth(
        q=q[:, :3],
        qd=qd[:, :3],
        q_rw=q[:, 3:] - q[0, 3:],
        qd_rw=qd[:, 3:],
        gyro=v[:, 3:],
        accelerometer=np.zeros((t.size, 3)),
        attitude=np.roll(x[:, 3:], -1, axis=1),
        position=x[:, :3] - x[0, :3],
        velocity=v[:, :3],
    )


@pytest.mark.long
def test_a_panel_whose_frequency_is_declared_wrongly(tmp_path: Path):
    """By 20 %, either way, with a CAD model that is off by 5 %."""
    (tmp_path / "sat.urdf").write_text(urdf())
    (tmp_path / "sat.yaml").write_text(FILE)
    true = load_robot(tmp_path / "sat.yaml")
    t, truth = flown(true)
    z = []
    for seed, off in enumerate((0.8, 1.2)):
        random = np.random.default_rng(seed)
        scale = 1 + 0.05 * random.standard_normal((len(true.bodies), 1))
        panel = true.passive["panel"]
        declared = replace(
            true,
            theta=true.theta * scale,
            passive={"panel": panel._replace(frequency=off * panel.frequency)},
        )
        recording = measure_truth(true, t, truth, seed)
        seen = {k: x for k, x in recording.columns.items() if "panel" not in k}
        result = identify(declared, replace(recording, columns=seen))
        assert result.status == "ok"
        found = result.springs["panel"]
        assert abs(found.frequency / panel.frequency - 1) < 0.01
        assert abs(found.frequency - panel.frequency) < 4 * found.frequency_std
        assert abs(found.damping - panel.damping) < 4 * found.damping_std
        beta = minimal_sets(declared).beta(true.theta)
        z.append((result.base.values - beta) / result.base.std)
    # Some fifty numbers, correlated: beyond 4.5 with a probability below 1e-3.
    assert np.nanmax(np.abs(z)) < 4.5
