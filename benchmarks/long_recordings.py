"""Memory and time of long recordings: of the command, in a process of its own.

Writes a recording and identifies it. The robot repeats its exciting trajectory for as
long as it takes; each repetition begins as the last one ended, so that momentum is
conserved throughout, and is measured with fresh noise. All noise is white: a bias would
jump where the next repetition begins.

    python benchmarks/long_recordings.py 10000000 --robot dual-arm --tracked
    python benchmarks/long_recordings.py 1000000 --method maximum-likelihood --rate 125

A recording is written into a folder that is removed at the end, or into `--folder`,
where it is found again the next time. Fails where the peak of the process, Python and
all, is above `--most`.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, count
from pathlib import Path

import numpy as np
from manoeuvres import dual_arm, excitation

from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_blocks
from orbident.robot.description import Robot
from orbident.robot.robot_file import write_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import made_along
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory import InitialState, Trajectory

MB = 1e6
ALWAYS = {
    "gyro": {"angle_random_walk": 2.9e-6},
    "joints": {"position": 2.5e-5},
    "wheels": {"position": 2.5e-5},
}
"""The noise of the bundled robots, SI."""
INERTIAL = {"accelerometer": {"velocity_random_walk": 1.7e-5}}
"""Integrated over the whole recording, which must be in memory."""
TRACKED = {"attitude": {"angle": 1.7e-5}, "position": {"std": 1e-4}}
"""With these in its place nothing is integrated, and stretches can be read alone."""
ROBOTS = {
    "paper-spatial": (spatial_robot, spatial_trajectory),
    "dual-arm": (dual_arm, excitation),
}


def main() -> None:
    """Write in this process, identify in another, and judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("samples", type=int)
    parser.add_argument("--robot", choices=ROBOTS, default="paper-spatial")
    parser.add_argument("--method", default="least-squares")
    parser.add_argument("--rate", type=float, default=1000.0, help="Hz")
    parser.add_argument("--tracked", action="store_true", help="not by accelerometer")
    parser.add_argument("--suffix", choices=("parquet", "csv"), default="parquet")
    parser.add_argument("--most", type=float, default=500.0, help="MB")
    parser.add_argument("--folder", type=Path)
    asked = parser.parse_args()
    make, move = ROBOTS[asked.robot]
    sensors = ALWAYS | (TRACKED if asked.tracked else INERTIAL)
    robot = replace(make(), sensors=declared_sensors(sensors))
    with tempfile.TemporaryDirectory() as temporary:
        folder = asked.folder or Path(temporary)
        folder /= f"{asked.robot}{'-tracked' if asked.tracked else ''}"
        path = folder / f"{asked.samples}-at-{asked.rate:g}-Hz.{asked.suffix}"
        if not path.exists():
            write_robot(robot, folder)
            pieces = repeated(robot, move(robot), asked.rate)
            written(path, pieces, asked.samples)
        command = Path(sys.executable).with_name("orbident")
        arguments = [command, "identify", folder / "robot.yaml", path, "--quiet"]
        peak = measured([*arguments, "--method", asked.method], asked.samples)
    sys.exit(peak > asked.most)


def repeated(robot: Robot, trajectory: Trajectory, rate: float) -> Iterator[Recording]:
    """The measured motion, one repetition after another, without end."""
    names, start, turned, r_S = robot.wheel_names, 0.0, 0.0, 0.0
    for seed in count():
        made = made_along(robot, trajectory, rate)
        true = made.true._replace(
            q_rw=made.true.q_rw + turned, position=made.true.position + r_S
        )
        recording = measure_truth(robot, made.t, true, seed)
        # The last row is the first one of the next repetition.
        columns = {name: x[:-1] for name, x in recording.columns.items()}
        yield Recording(start + made.t[:-1], columns, recording.source)
        start, turned, r_S = start + made.t[-1], true.q_rw[-1], true.position[-1]
        at_end = InitialState(
            true.gyro[-1],
            true.attitude[-1],
            true.velocity[-1],
            dict(zip(names, true.qd_rw[-1].tolist(), strict=True)),
        )
        trajectory = replace(trajectory, initial=at_end)


def written(path: Path, pieces: Iterator[Recording], samples: int) -> None:
    """Write so many rows of them."""
    started = time.perf_counter()
    first = next(pieces)
    write_blocks(path, ("t", *first.columns), tables(chain([first], pieces), samples))
    elapsed, size = time.perf_counter() - started, path.stat().st_size
    print(f"written in {elapsed:.0f} s: {size / MB:.0f} MB", flush=True)


def tables(pieces: Iterator[Recording], rows: int) -> Iterator[np.ndarray]:
    """So many rows of recordings, as tables."""
    for piece in pieces:
        yield np.column_stack([piece.t, *piece.columns.values()])[:rows]
        rows -= piece.t.size
        if rows <= 0:
            return


def measured(command: list[str | Path], samples: int) -> float:
    """The peak of the command's memory, MB.

    Raises:
        SystemExit: it refused the recording.
    """
    started = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    elapsed = time.perf_counter() - started
    peak = usage.ru_maxrss * 1024 / MB
    status = os.waitstatus_to_exitcode(status)
    print(
        f"{samples} samples: status {status}, {peak:.0f} MB, {elapsed:.1f} s, "
        f"{usage.ru_utime + usage.ru_stime:.1f} s of CPU, "
        f"{samples / elapsed:.0f} samples a second"
    )
    if status > 1:
        sys.exit(status)
    return peak


if __name__ == "__main__":
    main()
