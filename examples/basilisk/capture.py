"""A free flyer of Basilisk captures a body: when is it found, and what does it weigh?

python examples/basilisk/capture.py
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import (
    reactionWheelStateEffector,
    spacecraft,
    spinningBodyTwoDOFStateEffector,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW
from mass_properties import MassProperties

from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com
from orbident.robot.robot_file import load_robot
from orbident.simulation.capture import CapturedBody, holding

HERE = Path(__file__).parent
RATE = 20.0
STEPS = 10
"""Steps of the dynamics in each sample."""
TARGET = CapturedBody(12.0, np.array([0.9, 0.05, 0.0]), np.diag([0.4, 0.5, 0.6]))
HEAVIER = 1.1
"""The hub is so much heavier than CAD says."""
CAPTURE, END = 40.0, 90.0
"""s."""


class JointControl(sysModel.SysModel):
    """Joints follow sines: proportional and derivative control of their torques."""

    def __init__(self) -> None:
        """Two joints."""
        super().__init__()
        self.ModelTag = "jointControl"
        self.jointInMsgs = [messaging.HingedRigidBodyMsgReader() for _ in range(2)]
        self.torqueOutMsg = messaging.ArrayMotorTorqueMsg()
        self.wheelOutMsg = messaging.ArrayMotorTorqueMsg()

    def Reset(self, CurrentSimNanos: int) -> None:
        """Nothing is kept."""

    def UpdateState(self, CurrentSimNanos: int) -> None:
        """Torques of joints, by feedback, and of wheels, as planned."""
        t = CurrentSimNanos * 1e-9
        size, rate = np.array([0.8, 0.6]), np.array([0.45, 0.7])
        ramp = 1 - np.exp(-t / 3)
        wanted = ramp * size * np.sin(rate * t)
        speed = ramp * size * rate * np.cos(rate * t)
        speed += np.exp(-t / 3) / 3 * size * np.sin(rate * t)
        now = [message() for message in self.jointInMsgs]
        q, qd = np.array([j.theta for j in now]), np.array([j.thetaDot for j in now])
        torque = np.array([200.0, 80.0]) * (wanted - q)
        torque += np.array([80.0, 30.0]) * (speed - qd)
        wheels = 0.1 * np.sin(np.array([0.3, 0.5, 0.8]) * t)
        for message, values in (
            (self.torqueOutMsg, torque),
            (self.wheelOutMsg, wheels),
        ):
            payload = messaging.ArrayMotorTorqueMsgPayload()
            payload.motorTorque = values.tolist()
            message.write(payload, CurrentSimNanos, self.moduleID)


class Found(NamedTuple):
    """What the filter made of it."""

    changes: list[float]
    """When a change was found, s."""
    masses: dict[str, tuple[float, float, float]]
    """Before and after the capture: true, estimated, and its deviation, kg."""


def run() -> Found:
    """Simulate the capture, with the filter in the loop."""
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
    wheels.rwMotorCmdInMsg.subscribeTo(control.wheelOutMsg)
    walk = cad.sensors["gyro"]["angle_random_walk"]
    filter_ = MassProperties(cad, walk * np.sqrt(RATE), velocity_std=1e-4)
    filter_.scStateInMsg.subscribeTo(body.scStateOutMsg)
    filter_.rwSpeedInMsg.subscribeTo(wheels.rwSpeedOutMsg)
    for module in (control, filter_):
        for message, link in zip(
            module.jointInMsgs, links.spinningBodyOutMsgs, strict=True
        ):
            message.subscribeTo(link)
    for module in (body, links, wheels, control):
        simulation.AddModelToTask("fast", module)
    simulation.AddModelToTask("slow", filter_)

    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(CAPTURE))
    simulation.ExecuteSimulation()
    before = [e for e in filter_.events if e.kind == "estimate"][-1]
    held = holding(cad, TARGET).theta
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
    return Found([e.t for e in filter_.events if e.kind == "change"], masses)


def mass_com_inertia(theta: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), CM (m), and the inertia about it (kg m^2) of one body."""
    com = theta[FIRST_MOMENT] / theta[MASS]
    return float(theta[MASS]), com, inertia_about_com(theta)


def _hub(theta: np.ndarray) -> spacecraft.Spacecraft:
    mass, com, inertia = mass_com_inertia(theta)
    body = spacecraft.Spacecraft()
    body.hub.mHub, body.hub.r_BcB_B = mass, com.reshape(3, 1).tolist()
    body.hub.IHubPntBc_B = inertia.tolist()
    body.hub.omega_BN_BInit = [[0.01], [0.03], [0.025]]
    body.hub.sigma_BNInit = [[0.1], [0.2], [-0.1]]
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
        factory.create("Honeywell_HR16", axis, maxMomentum=50.0, Omega=1500.0)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, body)
    return wheels


if __name__ == "__main__":
    found = run()
    print(f"captured at {CAPTURE} s; changes found at {found.changes} s")
    for name, (true, value, std) in found.masses.items():
        print(f"mass {name}: true {true:.2f}, estimated {value:.2f} +- {std:.2f} kg")
