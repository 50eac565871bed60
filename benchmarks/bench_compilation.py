"""What the first simulation and identification of a process cost in compilation.

Each in a process of its own, without the cache on disk; the two robots by turns, so
that other work on the machine meets both. Compilation is what the first round takes
beyond the second, in processor time.
"""

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

LONGER = 1.5
ROUNDS = 3

PROGRAM = """
import json, sys, time
import jax

jax.config.update("jax_enable_x64", True)

import orbident
from manoeuvres import excitation

robot = orbident.load_robot(sys.argv[1])
trajectory = excitation(robot)

def work():
    wall, processor = time.perf_counter(), time.process_time()
    recording = orbident.simulate(robot, trajectory, rate=20.0)
    assert orbident.identify(robot, recording, "least-squares").status == "ok"
    return time.perf_counter() - wall, time.process_time() - processor

first, second = work(), work()
print(json.dumps({
    "first": first[0], "second": second[0], "compiling": first[1] - second[1]
}))
"""


def cold(robot: str) -> dict[str, float]:
    """Seconds, as a fresh process finds them."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    environment["PYTHONPATH"] = str(Path(__file__).parent)
    # Threads that wait for each other would count as work.
    environment["OPENBLAS_NUM_THREADS"] = "1"
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, robot],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(done.stdout)


@pytest.mark.benchmark(group="compilation (two cold processes)")
def bench_cold(benchmark):
    robots = ("paper-spatial", "dual-arm")
    rounds = {robot: [] for robot in robots}

    def both():
        for robot in robots:
            rounds[robot].append(cold(robot))

    benchmark.pedantic(both, rounds=ROUNDS)
    for robot, seconds in rounds.items():
        for name in seconds[0]:
            median = statistics.median(each[name] for each in seconds)
            benchmark.extra_info[f"{robot}: {name}"] = median
    small, large = (benchmark.extra_info[f"{robot}: compiling"] for robot in robots)
    benchmark.extra_info["ratio"] = large / small
    assert large <= LONGER * small
