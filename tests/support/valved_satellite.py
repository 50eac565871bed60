"""A satellite with eight valves on an air table, flown by sums of its own.

Nothing of Orbident integrates it: with what is switched between fine steps, yaw is the
double sum of the torque, and the place of the CM that of the force as it turns.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

ARMS = np.array(
    [
        (0.145, 0.06),
        (0.145, -0.06),
        (0.06, -0.145),
        (-0.06, -0.145),
        (-0.145, -0.06),
        (-0.145, 0.06),
        (-0.06, 0.145),
        (0.06, 0.145),
    ]
)
"""Where valves are, m."""

PUSHES = np.array(
    [(-1, 0), (-1, 0), (0, 1), (0, 1), (1, 0), (1, 0), (0, -1), (0, -1)], float
)

THRUST = 0.45
"""N, as the robot file says."""

FINE = 5e-4
"""s."""


@dataclass(frozen=True)
class Truth:
    """How a satellite is, and how its valves work."""

    mass: float = 23.09
    inertia: float = 0.33
    """About the CM, kg m^2."""
    com: tuple[float, float] = (0.0056, 0.0008)
    """From S, m."""
    gains: np.ndarray = field(default_factory=lambda: np.zeros(8))
    """Relative errors."""
    clock: float = 0.15
    pulse: float = -0.02
    coupling: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    """m/s^2."""
    walks: tuple[float, float] = (0.0, 0.0)
    """Densities of torque, N m/sqrt(Hz), and force, N/sqrt(Hz)."""


def satellite(folder: Path, gain: str = "20 %", more: str = "") -> Robot:
    """The robot file's: a nominal mass and inertia that are off."""
    valves = "\n".join(
        f"  - {{name: t{k}, position: [{a[0]}, {a[1]}, 0], "
        f"direction: [{p[0]}, {p[1]}, 0], thrust: {THRUST}, gain: {gain}}}"
        for k, (a, p) in enumerate(zip(ARMS, PUSHES, strict=True), start=1)
    )
    path = folder / "satellite.yaml"
    path.write_text(
        "schema: orbident/robot/1\nname: satellite\nmotion: planar\n"
        "bodies:\n  satellite: {mass: 20 kg, inertia: [0.3, 0.3, 0.3]}\n"
        f"thrusters:\n{valves}\n{more}"
    )
    return load_robot(path)


def commands(random: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Which valves are asked to be open from each row on: one to four, for a while."""
    on, row = np.zeros((t.size, 8)), 0
    while row < t.size:
        rows = int(random.integers(4, 20))
        on[row : row + rows, random.permutation(8)[: random.integers(0, 4)]] = 1.0
        row += rows
    return on


def opened(on: np.ndarray, t: np.ndarray, fine: np.ndarray, truth: Truth) -> np.ndarray:
    """The part of its thrust that each valve gives, at fine times."""
    found = np.tile(on[0], (fine.size, 1))
    for k in range(1, t.size):
        for valve in np.flatnonzero(on[k] != on[k - 1]):
            late = truth.clock + (truth.pulse if on[k, valve] < on[k - 1, valve] else 0)
            found[fine >= t[k] + late, valve] = on[k, valve]
    others = np.maximum(found.sum(axis=1, keepdims=True) - 1, 0)
    return found * (1 - truth.coupling * others) * (1 + truth.gains)


def flown(
    truth: Truth,
    seed: int,
    duration: float = 60.0,
    rate: float = 16.0,
    std: tuple[float, float] = (3e-4, 5e-4),
    valves: Sequence[int] = range(8),
) -> Recording:
    """A recording: pose with noise (m, rad), and what valves were asked for.

    There are these valves alone, named from t1 on.
    """
    random = np.random.default_rng(seed)
    t = np.arange(round(duration * rate) + 1) / rate
    on = commands(random, t)
    on[:, [k for k in range(8) if k not in valves]] = 0.0
    n = round(duration / FINE)
    fine = (np.arange(n) + 0.5) * FINE
    force = THRUST * opened(on, t, fine, truth)[:, :, None] * PUSHES
    r = ARMS - np.array(truth.com)
    torque = np.sum(r[:, 0] * force[..., 1] - r[:, 1] * force[..., 0], axis=1)
    white = random.standard_normal((n, 3)) / np.sqrt(FINE)
    torque += truth.walks[0] * white[:, 0]

    def summed(rate_of: np.ndarray, start: float) -> np.ndarray:
        """The integral of what is constant over each fine step."""
        return start + np.concatenate([[0.0], np.cumsum(rate_of) * FINE])

    w = summed(torque / truth.inertia, random.uniform(-0.1, 0.1))
    yaw = summed((w[1:] + w[:-1]) / 2, random.uniform(-3.0, 3.0))
    middle = (yaw[1:] + yaw[:-1]) / 2
    c, s = np.cos(middle), np.sin(middle)
    total = force.sum(axis=1)
    turned = np.column_stack(
        [c * total[:, 0] - s * total[:, 1], s * total[:, 0] + c * total[:, 1]]
    )
    turned += truth.walks[1] * white[:, 1:]
    place = []
    for axis in range(2):
        v = summed(
            turned[:, axis] / truth.mass + truth.tilt[axis], random.normal(0, 0.02)
        )
        place.append(summed((v[1:] + v[:-1]) / 2, 0.0))
    rows = np.round(t / FINE).astype(int)
    yaw, x, y = yaw[rows], place[0][rows], place[1][rows]
    c, s = np.cos(yaw), np.sin(yaw)
    x = (
        x
        - c * truth.com[0]
        + s * truth.com[1]
        + std[0] * random.standard_normal(t.size)
    )
    y = (
        y
        - s * truth.com[0]
        - c * truth.com[1]
        + std[0] * random.standard_normal(t.size)
    )
    yaw = yaw + std[1] * random.standard_normal(t.size)
    zero = np.zeros(t.size)
    columns: dict[str, Any] = {
        "position.x": x,
        "position.y": y,
        "position.z": zero,
        "attitude.x": zero,
        "attitude.y": zero,
        "attitude.z": np.sin(yaw / 2),
        "attitude.w": np.cos(yaw / 2),
    }
    columns |= {
        f"thruster.t{name}.duty": on[:, k] for name, k in enumerate(valves, start=1)
    }
    return Recording(t, columns)


def base_of(truth: Truth) -> np.ndarray:
    """`[M, sigma, iota]` of a satellite without joints; `iota` is `Izz` about S."""
    M, c = truth.mass, np.array(truth.com)
    return np.array([M, *(M * c), truth.inertia + M * c @ c])


def with_dead(truth: Truth, valve: int) -> Truth:
    """The same with a valve, from one on, that gives nothing."""
    gains = truth.gains.copy()
    gains[valve - 1] = -1.0
    return replace(truth, gains=gains)
