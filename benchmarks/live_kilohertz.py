"""`orbident live` in real time: a kilohertz of datagrams for ten minutes, on one core.

Sends a flight of the paper's servicer from one core to the command on another, and
tells every minute how much memory the command has. Fails where a sample is lost:

    python benchmarks/live_kilohertz.py
    python benchmarks/live_kilohertz.py --rate 10000 --seconds 20
"""

import argparse
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from orbident.live.sources import needed_columns
from orbident.recordings.columns import vector_columns
from orbident.robot.description import Robot
from orbident.simulation.simulate import made_along
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory import Trajectory

LIVE, SENDER = 0, 1
"""Cores."""
VELOCITY_STD = 1e-3
"""m/s."""
PERIODS = np.arange(1, 61)
"""Periods of the joints' motion in a flight."""


def main() -> None:
    """Simulate, send, and judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--rate", type=float, default=1000.0, help="Hz")
    given = parser.parse_args()
    os.sched_setaffinity(0, {SENDER})
    lines = flown(spatial_robot(), given.seconds, given.rate)
    with tempfile.TemporaryDirectory() as folder:
        state = Path(folder, "state")
        sys.exit(0 if watched(lines, given.rate, state) else 1)


def flown(robot: Robot, seconds: float, rate: float) -> list[bytes]:
    """A header, then a line a sample, with the sensors' noise."""
    random = np.random.default_rng(0)
    joints = len(robot.joints)
    # Of periods from ten seconds to a minute.
    size = 0.1 * ((seconds / PERIODS > 10) & (seconds / PERIODS < 60))
    a, b = size * random.standard_normal((2, joints, PERIODS.size))
    at_rest = np.zeros((joints, 3))
    initial = spatial_trajectory(robot).initial
    motion = Trajectory(
        seconds,
        robot.joint_names,
        a=a,
        b=b,
        start=at_rest,
        end=at_rest,
        initial=initial,
    )
    made = made_along(robot, motion, rate)
    exact = made.true.columns(robot)
    walk = robot.sensors.of("gyro").white_std()
    std = {"gyro": walk * np.sqrt(rate), "velocity": VELOCITY_STD}
    columns = {"t": made.t}
    for name in (*needed_columns(robot)[1:], *vector_columns("velocity")):
        noise = std.get(name.split(".")[0], 0.0) * random.standard_normal(made.t.size)
        columns[name] = exact[name] + noise
    rows = np.column_stack(list(columns.values()))
    return [
        ",".join(columns).encode(),
        *(",".join(map(repr, row.tolist())).encode() for row in rows),
    ]


def watched(lines: list[bytes], rate: float, state: Path) -> bool:
    """Whether every line that was sent has come, and none is late or missing."""
    process = subprocess.Popen(
        [
            *("taskset", "-c", str(LIVE)),
            *(Path(sys.executable).with_name("orbident"), "live", "paper-spatial"),
            *("--udp", "0", "--velocity-std", str(VELOCITY_STD), "--state", state),
        ],
        stdout=subprocess.PIPE,
    )
    assert process.stdout is not None
    port = json.loads(process.stdout.readline())["udp"]
    told: list[tuple[float, dict]] = []

    def listen() -> None:
        for line in process.stdout or ():
            told.append((time.perf_counter(), json.loads(line)))

    listener = threading.Thread(target=listen)
    listener.start()
    started = sent(lines, rate, port, process.pid)
    time.sleep(5.0)
    # In the background of a shell SIGINT is ignored.
    process.send_signal(signal.SIGTERM)
    listener.join()
    _, _, usage = os.wait4(process.pid, 0)
    estimates = [(at, e) for at, e in told if e["event"] == "estimate"]
    delays = [at - started - event["t"] for at, event in estimates]
    _, end = told[-1]
    counts, size = end["counts"], len(lines) - 1
    print(f"estimates are {np.median(delays):.2f} s old, {max(delays):.2f} s at most")
    print(f"{usage.ru_utime + usage.ru_stime:.1f} s of CPU; counts: {counts}")
    print(f"sent {size} at {rate:g} Hz, lost {size - sum(counts.values())}, of which")
    print(f"{end['lost_datagrams']} are counted as lost datagrams")
    print(f"the mass is {end['mass']}, and truly {spatial_robot().mass:g} kg")
    right = {"counted", "unsmoothed", "averaged", "waiting"}
    return sum(counts.get(name, 0) for name in right) == size


def sent(lines: list[bytes], rate: float, port: int, reader: int) -> float:
    """Send each line at its time; returns that of the first, by this process' clock."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", port))
        sender.send(lines[0])
        started, late = time.perf_counter(), 0.0
        for k, line in enumerate(lines[1:]):
            due = started + k / rate
            while (wait := due - time.perf_counter()) > 0:
                time.sleep(wait)
            late = max(late, -wait)
            sender.send(line)
            if k % (60 * rate) == 0:
                print(f"{k / rate:.0f} s: {memory(reader):.1f} MB", flush=True)
    print(f"{len(lines) - 1} samples; the sender was at most {late:.3f} s late")
    print(f"at the end: {memory(reader):.1f} MB")
    return started


def memory(process: int) -> float:
    """What a process has in memory, MB."""
    status = Path(f"/proc/{process}/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) * 1024 / 1e6


if __name__ == "__main__":
    main()
