"""A first look: a robot that is not what CAD says, flown, identified and predicted.

The robot is the paper's servicer. Mass, CM and inertia of each body differ from CAD,
instruments are off as they usually are, and a slow torque acts. What is identified from
one flight predicts another one, which has other motions of the joints.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.campaigns.case import Case, Subject, recorded
from orbident.campaigns.spec import Disperse
from orbident.estimation.result import Result
from orbident.identified.prediction import Prediction
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import rotation_angle
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.schema import TolerancesEntry
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.environment import Environment

WRONG = 0.1
"""How far CAD is off: each mass, CM and inertia by this part, up or down."""

VARIED = Disperse.model_validate(
    {"inertia": {"signs": WRONG}, "instruments": {"normal": 1.0}}
)
TORQUE = 1e-3
"""N m: a thousandth of what the wheels of such a spacecraft give."""

ACTING = Environment.model_validate(
    {"slow_torque": {"std": TORQUE, "correlation_time": "100 s"}}
)
UNSAID = {"disturbances", "tolerances"}
"""What the bundled file rules out and this robot's file does not mention, so that what
may act, and how far instruments may be off, is as usual."""


@dataclass(frozen=True, eq=False)
class DemoFlights:
    """Two flights of one robot."""

    robot: Robot
    """As its file has it, with the inertia of CAD."""
    flown: Robot
    """As it is."""
    first: Recording
    """To identify from."""
    other: Recording
    """Of another motion, to be predicted."""

    def true_base(self) -> Float[np.ndarray, " beta"]:
        """The true base parameters, in the order of a result's."""
        return minimal_sets(self.robot).beta(self.flown.theta)

    def farthest(self, result: Result) -> float:
        """How far a true value is from a result's at most, in standard deviations."""
        off = (result.base.values - self.true_base()) / result.base.std
        return float(np.abs(off).max())


def fly_demo(seed: int = 0) -> DemoFlights:
    """Draws the robot that flies, and flies it twice."""
    robot = spatial_robot()
    said = {key: x for key, x in robot.document.items() if key not in UNSAID}
    usual = TolerancesEntry().in_si(robot.joints, robot.thrusters, (), robot.name)
    robot = replace(robot, disturbances=None, tolerances=usual, document=said)
    motion = replace(spatial_trajectory(robot), environment=ACTING)
    case = Case(0, Subject(robot, motion, robot.name), VARIED, seed)
    # The joints exchange their motions.
    other = replace(motion, a=motion.a[::-1], b=motion.b[::-1])
    again = recorded(case.robot, other, case.instrument_errors, seed + 1)
    return DemoFlights(robot, case.robot, case.recording(), again)


def turned_off(prediction: Prediction) -> Float[np.ndarray, " n"]:
    """By what angle the predicted attitude is off the measured one, rad."""
    return rotation_angle(prediction.measured.x_WB, prediction.x_WB)
