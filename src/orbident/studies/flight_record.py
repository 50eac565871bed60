"""Free flights as recordings: what the sensors saw, and how the thrusters fired."""

import numpy as np
from jaxtyping import Float

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.flight import FreeFlying
from orbident.simulation.measure import measure_truth
from orbident.simulation.truth import truth_of_flight


def ideal_record(robot: Robot, flight: FreeFlying) -> Recording:
    """As ideal sensors of everything would have recorded it.

    Args:
        robot: that flew.
        flight: at the times of the rows.
    """
    columns = truth_of_flight(flight).columns(robot) | _thrust(flight)
    return Recording(flight.t, columns, source=f"flight of {robot.name}")


def measured_record(robot: Robot, flight: FreeFlying, seed: int) -> Recording:
    """As the sensors of the robot's file recorded it.

    Args:
        robot: that flew, with its sensors.
        flight: at the times of the rows, evenly spaced.
        seed: of the sensors' noise.

    Raises:
        InputError: a sensor cannot sample at these times.
    """
    seen = measure_truth(robot, flight.t, truth_of_flight(flight), seed)
    columns = {**seen.columns, **_thrust(flight)}
    return Recording(flight.t, columns, source=f"flight of {robot.name}, seed {seed}")


def _thrust(flight: FreeFlying) -> dict[str, Float[np.ndarray, " n"]]:
    """What the valves were told: it is known, not measured."""
    return {
        f"{name}.{axis}": vector[:, k]
        for name, vector in (("force", flight.force), ("torque", flight.torque))
        for k, axis in enumerate("xyz")
    }
