"""Memory and rate: what the command needs to identify millions of samples.

Writes a flight again and again into one file, which never is in memory, and identifies
it by the command in a fresh process. Fails where the peak of that process, Python and
all, is above 500 MB:

    python benchmarks/million_samples.py
    python benchmarks/million_samples.py --robot paper-spatial --samples 10000000
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from manoeuvres import dual_arm, excitation

from orbident import simulate
from orbident.recordings.recording import Recording
from orbident.recordings.table_writer import write_blocks
from orbident.robot.robot_file import write_robot
from orbident.studies.spatial import spatial_robot, spatial_trajectory

MB = 1e6
MOST = 500 * MB
RATE = 1000.0
"""Hz."""
PAUSE = 1.0
"""Between two flights, s."""


def main() -> None:
    """Write in this process, identify in another, and judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--robot", default="dual-arm")
    parser.add_argument("--method", default="least-squares")
    parser.add_argument("--suffix", default="parquet")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"recording.{asked.suffix}")
        robot = dual_arm() if asked.robot == "dual-arm" else spatial_robot()
        motion = excitation if asked.robot == "dual-arm" else spatial_trajectory
        flight = simulate(robot, motion(robot), rate=RATE)
        write_blocks(path, ("t", *flight.columns), again(flight, asked.samples))
        write_robot(robot, Path(folder, "robot"))
        command = Path(sys.executable).with_name("orbident")
        sys.exit(
            measured(
                [
                    *(command, "identify", Path(folder, "robot", "robot.yaml"), path),
                    *("--method", asked.method, "--quiet"),
                ],
                asked.samples,
            )
        )


def again(flight: Recording, samples: int) -> Iterator[np.ndarray]:
    """The flight, and the same after a pause, and so on."""
    table = np.column_stack([flight.t, *flight.columns.values()])
    while samples > 0:
        yield table[:samples]
        table[:, 0] += flight.t[-1] + PAUSE
        samples -= len(table)


def measured(command: list[str | Path], samples: int) -> int:
    """Exit status: 0 where the process stays within the bound."""
    started = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    elapsed = time.perf_counter() - started
    cpu = usage.ru_utime + usage.ru_stime
    peak = usage.ru_maxrss * 1024
    print(
        f"{samples} samples: status {status >> 8}, {peak / MB:.0f} MB peak, "
        f"{elapsed:.1f} s, {cpu:.1f} s of CPU, {samples / elapsed:.0f} samples a second"
    )
    return int(bool(status) or peak > MOST)


if __name__ == "__main__":
    main()
