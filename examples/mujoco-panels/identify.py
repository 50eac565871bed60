"""Panels that swing, flown by MuJoCo: nobody measures them, and they are identified.

Arm and wheels follow commands; base and panels move as they must.

python examples/mujoco-panels/identify.py
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from pathlib import Path

import mujoco
import numpy as np

from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.measure import Truth, measure_truth

HERE = Path(__file__).parent

DURATION, EVERY = 60.0, 20
"""s; steps from row to row."""

SPIN = np.array([150.0, -120.0, 100.0])
"""Speed of the wheels at the start, rad/s."""


def commanded(t: float) -> np.ndarray:
    """Angles of shoulder and elbow, rad, and rates of the wheels, rad/s."""
    begun = 1 - np.exp(-((t / 3) ** 3))
    shoulder = 0.5 * np.sin(0.5 * t) + 0.25 * np.sin(0.9 * t)
    elbow = 0.6 * np.sin(0.7 * t) + 0.2 * np.sin(1.2 * t)
    return np.r_[begun * shoulder, begun * elbow, SPIN * (1 + 0.3 * np.sin(0.15 * t))]


def control(_: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Between steps too: what is held for a step is late by a twelfth of it."""
    data.ctrl[:] = commanded(data.time)


def flown(robot: Robot, model_file: Path) -> tuple[np.ndarray, Truth]:
    """Times of the rows, s, and what perfect sensors would show there."""
    model = mujoco.MjModel.from_xml_path(str(model_file))
    data = mujoco.MjData(model)
    names = [*robot.joint_names, *robot.wheel_names]
    at = [model.joint(name).qposadr[0] for name in names]
    data.qvel[[model.joint(name).dofadr[0] for name in robot.wheel_names]] = SPIN
    rows = []
    mujoco.set_mjcb_control(control)
    for k in range(round(DURATION / model.opt.timestep) + 1):
        if k % EVERY == 0:
            mujoco.mj_forward(model, data)
            rates = [data.joint(name).qvel[0] for name in names]
            rows.append(
                (data.time, *data.qpos[:7], *data.qvel[:6], *data.qpos[at], *rates)
            )
        mujoco.mj_step(model, data)
    mujoco.set_mjcb_control(None)
    t, r, x, v, w, q, q_rw, qd, qd_rw = np.split(
        np.array(rows),
        np.cumsum([1, 3, 4, 3, 3, len(robot.joints), 3, len(robot.joints)]),
        1,
    )
    return t[:, 0], Truth(
        **{"q": q, "qd": qd, "q_rw": q_rw, "qd_rw": qd_rw, "gyro": w},
        **{"attitude": np.roll(x, -1, axis=1), "position": r - r[0], "velocity": v},
        accelerometer=np.zeros_like(w),
    )


def recorded(
    robot: Robot, seed: int, model_file: Path = HERE / "satellite.xml"
) -> Recording:
    """The flight as sensors show it: nothing of the panels."""
    return measure_truth(robot, *flown(robot, model_file), seed)


def main() -> None:
    """How the panels swing, and the parameters."""
    robot = load_robot(HERE / "satellite.yaml")
    result = identify(robot, recorded(robot, 0))
    print(result)
    for name, fit in result.springs.items():
        print(f"{name}: {fit.frequency:.4f} +- {fit.frequency_std:.2g} Hz")


if __name__ == "__main__":
    main()
