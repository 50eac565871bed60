"""What the first simulation and identification of a process cost in compilation.

Each in a process of its own, without the cache on disk. XLA's own account of it is
compared, which other work on the machine disturbs less than the clock.
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
from jax import monitoring

jax.config.update("jax_enable_x64", True)
spent = []
def listen(event, seconds, **_):
    if event.startswith("/jax/core/compile/"):
        spent.append(seconds)
monitoring.register_event_duration_secs_listener(listen)

import orbident
from manoeuvres import excitation

robot = orbident.load_robot(sys.argv[1])
trajectory = excitation(robot)
def work():
    started = time.perf_counter()
    recording = orbident.simulate(robot, trajectory, rate=20.0)
    assert orbident.identify(robot, recording).status == "ok"
    return time.perf_counter() - started
first = work()
compiled = sum(spent)
print(json.dumps({"compiling": compiled, "first": first, "second": work()}))
"""


def cold(robot: str) -> dict[str, float]:
    """Seconds, as a fresh process finds them."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    environment["PYTHONPATH"] = str(Path(__file__).parent)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, robot],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(done.stdout)


@pytest.mark.benchmark(group="compilation (the whole cold process)")
@pytest.mark.parametrize("robot", ["paper-spatial", "dual-arm"])
def bench_cold(benchmark, medians, robot):
    rounds = []
    benchmark.pedantic(lambda: rounds.append(cold(robot)), rounds=ROUNDS)
    seconds = {name: statistics.median(r[name] for r in rounds) for name in rounds[0]}
    benchmark.extra_info.update(seconds)
    medians[robot] = seconds["compiling"]
    if robot == "dual-arm" and "paper-spatial" in medians:
        ratio = medians["dual-arm"] / medians["paper-spatial"]
        benchmark.extra_info["ratio"] = ratio
        assert ratio <= LONGER
