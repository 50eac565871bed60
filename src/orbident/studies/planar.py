"""Section 5: the planar two-joint robot, and what it was told to do."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.control_laws import JointPD, WheelLimits, WheelSpeed
from orbident.simulation.thrusters import Pulse
from orbident.studies import paper_tables
from orbident.trajectories.trajectory import InitialState, Trajectory

# The paper gives neither gains nor motors: what such a robot would have. The arm
# follows Table 5 to 0.03 rad, and locked it gives way by 0.002 rad.
FOLLOWING = JointPD(Kp=np.array([1.0, 0.4]), Kd=np.array([0.2, 0.04]))
LOCKED = JointPD(Kp=np.array([5.0, 5.0]), Kd=np.array([0.2, 0.2]))
WHEEL = WheelSpeed(
    k=np.array([0.05]), speed=np.array([float(paper_tables.PLANAR_WHEEL_SPEED)])
)
MOTOR = WheelLimits(torque=np.array([0.05]), speed=np.array([np.inf]))

FOLDED = np.array([2.5, -2.09])
"""Joints at those of Eq. 46's limits that fold the arm over the base, rad."""

THRUSTERS = ("t2", "t3", "t6")
"""The thrusters that push down the table, with no moment about S together."""


class Sines(NamedTuple):
    """Joints that always swing: `q = amplitude sin(2 pi t / period)` (Eq. 47)."""

    amplitudes: Float[np.ndarray, " joints"]
    """rad."""
    period: float
    """s."""

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
    ]:
        """Positions, rates and accelerations at these times."""
        rate = 2 * np.pi / self.period
        sines = np.sin(rate * t)[:, None] * self.amplitudes
        cosines = np.cos(rate * t)[:, None] * self.amplitudes
        return sines, rate * cosines, -(rate**2) * sines


def planar_robot() -> Robot:
    """The stand-in for Cepheus."""
    return load_robot("cepheus-like")


def planar_trajectory(robot: Robot) -> Trajectory:
    """Table 5's exciting trajectory, with the wheel at the speed of Eq. 45."""
    at_rest = np.zeros((len(robot.joints), 3))
    speeds = dict.fromkeys(robot.wheel_names, paper_tables.PLANAR_WHEEL_SPEED)
    return Trajectory(
        duration=paper_tables.PLANAR_DURATION,
        joints=robot.joint_names,
        a=np.array(paper_tables.PLANAR_A),
        b=np.array(paper_tables.PLANAR_B),
        start=at_rest,
        end=at_rest,
        initial=InitialState(wheel_speed=speeds),
        source="Table 5",
    )


def validation_command() -> Sines:
    """Eq. 47."""
    return Sines(
        np.array(paper_tables.VALIDATION_AMPLITUDES),
        period=paper_tables.VALIDATION_DURATION,
    )


def burn_pulses(robot: Robot) -> tuple[Pulse, ...]:
    """Section 5.5's force from three thrusters, without a moment about S.

    About the CM a moment is left, which the wheel has to take.
    """
    by_name = {thruster.name: thruster for thruster in robot.thrusters}
    wrenches = []
    for name in THRUSTERS:
        arm = by_name[name].position - robot.feature_point
        unit = by_name[name].direction
        wrenches.append([*unit[:2], np.cross(arm, unit)[2]])
    forces = np.linalg.solve(np.transpose(wrenches), [*paper_tables.BURN_FORCE, 0.0])
    on, off = paper_tables.BURN_START, paper_tables.BURN_START + paper_tables.BURN_LASTS
    return tuple(
        Pulse(name, on, off, float(force))
        for name, force in zip(THRUSTERS, forces, strict=True)
    )
