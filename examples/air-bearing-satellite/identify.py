"""A real satellite on an air-bearing floor: what its valves and its body are.

The file is `Data/Real_Test/Test/real_test_data.csv` of the public repository
AevarOfjord/mpc-air-bearing-satellite. Commands are recorded when they are sent. With
valves that are said to act at once the recording is refused; with a tolerance of their
clock it is identified, a dead valve included.

python examples/air-bearing-satellite/identify.py real_test_data.csv
"""

import ast
import csv
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbident.estimation.identify import identify
from orbident.recordings.recording import Recording
from orbident.report.write import write_report
from orbident.robot.description import KnownQuantities, Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.units import MeasuredQuantity

HERE = Path(__file__).parent

END = 130.0
"""s: what came later is kept for a check."""

SCALES = KnownQuantities(mass=MeasuredQuantity(23.09, 0.01))
"""Mass of the satellite by three scales under its pads, kg."""


def recording(path: Path, begin: float = 0.0, end: float = END) -> Recording:
    """A part of the flight, from its measured columns; times in s."""
    with path.open() as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if begin <= float(row["MPC_Start_Time"]) <= end
        ]
    t, x, y, yaw = (
        np.array([float(row[name]) for row in rows])
        for name in ("MPC_Start_Time", "Current_X", "Current_Y", "Current_Yaw")
    )
    on = np.array([ast.literal_eval(row["Command_Vector"]) for row in rows], float)
    half, zero = np.unwrap(yaw) / 2, np.zeros(t.size)
    pose = {
        **{"position.x": x, "position.y": y, "position.z": zero},
        **{"attitude.x": zero, "attitude.y": zero},
        **{"attitude.z": np.sin(half), "attitude.w": np.cos(half)},
    }
    duty = {f"thruster.t{k}.duty": on[:, k - 1] for k in range(1, 9)}
    return Recording(t, pose | duty, str(path))


def without_latency(robot: Robot) -> Robot:
    """The robot whose valves act at once."""
    at_once = {"thruster_clock": 0.0, "thruster_pulse": 0.0}
    return replace(robot, tolerances=replace(robot.tolerances, **at_once))


def main(path: Path) -> None:
    """What becomes of the flight, with valves that act at once and as they do."""
    robot, flight = load_robot(HERE / "satellite.yaml"), recording(path)
    for name, each in (
        ("valves that act at once", without_latency(robot)),
        ("by the thrust of a bench", robot),
        ("with the mass of scales", replace(robot, known=SCALES)),
    ):
        result = identify(each, flight)
        print(f"{name}: {result.status}")
        for words in result.warnings:
            print(f"  {words}")
        if result.status != "ok":
            continue
        M = result.mass
        print(f"  mass {M.value:.2f} +- {M.std:.2g} kg")
        for error, fit in result.calibration.items():
            print(f"  {error:20} {fit.value:8.3f} +- {fit.std:.2g}")
    run = Path("run")
    run.mkdir(exist_ok=True)
    print(write_report(result, run))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
