"""A free flyer of Basilisk captures a body: when is it found, and what does it weigh?

Wheels hold the hub to a planned attitude while the arm moves. They are given what the
arm will take from the hub's momentum, by CAD or by what is identified meanwhile.

python examples/basilisk/capture.py
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from attitude_control import AttitudeControl, Plan
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import (
    reactionWheelStateEffector,
    spacecraft,
    spinningBodyTwoDOFStateEffector,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW
from mass_properties import MassProperties
from scipy.spatial.transform import Rotation

from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    from_mass_com_inertia,
    inertia_about_com,
)
from orbident.robot.robot_file import load_robot

HERE = Path(__file__).parent
RATE = 20.0
STEPS = 10
"""Steps of the dynamics in each sample."""
TARGET = from_mass_com_inertia(
    12.0, np.array([0.9, 0.05, 0.0]), np.diag([0.4, 0.5, 0.6])
)
"""In the frame of the last link, to which it is attached."""
HEAVIER = 1.1
"""The hub is so much heavier than CAD says."""
CAPTURE, END = 40.0, 90.0
"""s."""
SETTLED = 10.0
"""s after the capture, when the identified parameters are used and count."""
START = Rotation.from_mrp([0.1, 0.2, -0.1])


def joints_at(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Sines that begin at rest: positions and rates of both joints."""
    size, rate = np.array([0.6, 0.5]), np.array([0.35, 0.5])
    ramp = 1 - np.exp(-t / 3)
    qd = ramp * size * rate * np.cos(rate * t)
    qd += np.exp(-t / 3) / 3 * size * np.sin(rate * t)
    return ramp * size * np.sin(rate * t), qd


def attitude_at(t: float) -> Rotation:
    """The hub turns to and fro about all axes, which shows its inertia."""
    return START * Rotation.from_rotvec(0.1 * np.sin(np.array([0.3, 0.5, 0.8]) * t))


class JointControl(sysModel.SysModel):
    """Joints follow the plan: proportional and derivative control of their torques."""

    def __init__(self) -> None:
        """Two joints."""
        super().__init__()
        self.ModelTag = "jointControl"
        self.jointInMsgs = [messaging.HingedRigidBodyMsgReader() for _ in range(2)]
        self.torqueOutMsg = messaging.ArrayMotorTorqueMsg()

    def Reset(self, CurrentSimNanos: int) -> None:
        """Nothing is kept."""

    def UpdateState(self, CurrentSimNanos: int) -> None:
        """Torques by feedback."""
        wanted, speed = joints_at(CurrentSimNanos * 1e-9)
        now = [message() for message in self.jointInMsgs]
        q, qd = np.array([j.theta for j in now]), np.array([j.thetaDot for j in now])
        torque = np.array([200.0, 80.0]) * (wanted - q)
        torque += np.array([80.0, 30.0]) * (speed - qd)
        payload = messaging.ArrayMotorTorqueMsgPayload()
        payload.motorTorque = torque.tolist()
        self.torqueOutMsg.write(payload, CurrentSimNanos, self.moduleID)


class Found(NamedTuple):
    """What the filter made of it."""

    changes: list[float]
    """When a change was found, s."""
    masses: dict[str, tuple[float, float, float]]
    """Before and after the capture: true, estimated, and its deviation, kg."""
    error: float
    """Root mean square error of the hub's attitude after the capture, rad."""


def run(by_cad: bool = False) -> Found:
    """Simulate the capture, with the filter in the loop.

    Args:
        by_cad: the wheels' control uses CAD values, not what the filter identified.
    """
    cad = load_robot(str(HERE / "free_flyer.yaml"))
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("fast", macros.sec2nano(1 / RATE / STEPS)))
    process.addTask(simulation.CreateNewTask("slow", macros.sec2nano(1 / RATE)))

    theta = cad.theta.copy()
    theta[0] *= HEAVIER
    body, arm = _hub(theta[0]), spinningBodyTwoDOFStateEffector
    links = arm.SpinningBodyTwoDOFStateEffector()
    _set_links(links, cad, theta)
    body.addStateEffector(links)
    wheels = _wheels(body)

    control = JointControl()
    links.motorTorqueInMsg.subscribeTo(control.torqueOutMsg)
    gyro_std = cad.sensors.of("gyro").white_std(1 / RATE)
    filter_ = MassProperties(cad, gyro_std, velocity_std=1e-4)
    pointing = AttitudeControl(
        Plan(joints_at, attitude_at), lambda: cad if by_cad else filter_.identified
    )
    wheels.rwMotorCmdInMsg.subscribeTo(pointing.wheelOutMsg)
    for module in (pointing, filter_):
        module.scStateInMsg.subscribeTo(body.scStateOutMsg)
        module.rwSpeedInMsg.subscribeTo(wheels.rwSpeedOutMsg)
    for module in (control, pointing, filter_):
        for message, link in zip(
            module.jointInMsgs, links.spinningBodyOutMsgs, strict=True
        ):
            message.subscribeTo(link)
    for module in (body, links, wheels, control, pointing):
        simulation.AddModelToTask("fast", module)
    simulation.AddModelToTask("slow", filter_)

    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(CAPTURE))
    simulation.ExecuteSimulation()
    before = [e for e in filter_.events if e.kind == "estimate"][-1]
    held = cad.theta.copy()
    held[-1] += TARGET
    held[0] *= HEAVIER
    _set_links(links, cad, held)
    simulation.ConfigureStopTime(macros.sec2nano(END))
    simulation.ExecuteSimulation()
    after = [e for e in filter_.events if e.kind == "estimate"][-1]
    masses = {
        name: (true, estimate.of["beta"][0], estimate.of["std"][0])
        for name, true, estimate in (
            ("before", theta[:, 0].sum(), before),
            ("after", held[:, 0].sum(), after),
        )
    }
    errors = [e for t, e in pointing.errors if t > CAPTURE + SETTLED]
    changes = [e.t for e in filter_.events if e.kind == "change"]
    return Found(changes, masses, float(np.sqrt(np.mean(np.square(errors)))))


def mass_com_inertia(theta: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), CM (m), and the inertia about it (kg m^2) of one body."""
    com = theta[FIRST_MOMENT] / theta[MASS]
    return float(theta[MASS]), com, inertia_about_com(theta)


def _hub(theta: np.ndarray) -> spacecraft.Spacecraft:
    mass, com, inertia = mass_com_inertia(theta)
    body = spacecraft.Spacecraft()
    body.hub.mHub, body.hub.r_BcB_B = mass, com.reshape(3, 1).tolist()
    body.hub.IHubPntBc_B = inertia.tolist()
    body.hub.omega_BN_BInit = [[x] for x in Plan(joints_at, attitude_at).rate(0.0)]
    body.hub.sigma_BNInit = [[x] for x in START.as_mrp()]
    return body


def _set_links(links: object, robot: Robot, theta: np.ndarray) -> None:
    """Geometry of the robot, and these parameters; also while the simulation runs."""
    first, second = robot.joints
    links.r_S1B_B, links.r_S2S1_S1 = ([[x] for x in j.p_PJ] for j in (first, second))
    links.s1Hat_S1, links.s2Hat_S2 = ([[x] for x in j.axis] for j in (first, second))
    links.mass1, com, links_inertia = mass_com_inertia(theta[1])
    links.r_Sc1S1_S1 = [[x] for x in com]
    links.IS1PntSc1_S1 = links_inertia.tolist()
    links.mass2, com, links_inertia = mass_com_inertia(theta[2])
    links.r_Sc2S2_S2 = [[x] for x in com]
    links.IS2PntSc2_S2 = links_inertia.tolist()
    links.dcm_S10B = links.dcm_S20S1 = np.eye(3).tolist()


def _wheels(
    body: spacecraft.Spacecraft,
) -> reactionWheelStateEffector.ReactionWheelStateEffector:
    factory = simIncludeRW.rwFactory()
    for axis in np.eye(3).tolist():
        # Wheels that are strong enough for so fast an arm.
        factory.create(
            "Honeywell_HR16",
            axis,
            maxMomentum=50.0,
            Omega=1500.0,
            useMaxTorque=False,
        )
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, body)
    return wheels


if __name__ == "__main__":
    found = run()
    print(f"captured at {CAPTURE} s; changes found at {found.changes} s")
    for name, (true, value, std) in found.masses.items():
        print(f"mass {name}: true {true:.2f}, estimated {value:.2f} +- {std:.2f} kg")
    for name, error in ("CAD", run(by_cad=True).error), ("the estimate", found.error):
        print(
            f"attitude after the capture, wheels by {name}: {1e3 * error:.2f} mrad off"
        )
