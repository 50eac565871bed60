"""Streams of samples as a laboratory sends them: noisy, causal, one line a sample."""

import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
from random_motions import random_motion

from orbident.live.lines import VELOCITY, needed_columns
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.capture import (
    CapturedBody,
    holding,
    truth_through_change,
)
from orbident.simulation.simulate import made_along, sample_times

NAME, DURATION, RATE = "paper-spatial", 30.0, 20.0
VELOCITY_STD = 1e-3
CAPTURED = CapturedBody(60.0, np.array([0.4, 0.1, 0.0]), np.diag([5.0, 6.0, 7.0]))


@cache
def robot() -> Robot:
    return load_robot(NAME)


@cache
def samples(captured_at: float | None = None) -> dict[str, np.ndarray]:
    """Columns by name, `t` among them."""
    motion, t = random_motion(robot(), duration=DURATION), sample_times(DURATION, RATE)
    if captured_at is None:
        true = made_along(robot(), motion, RATE).true
    else:
        held = holding(robot(), CAPTURED)
        true = truth_through_change(robot(), held, motion, captured_at, t)
    random = np.random.default_rng(0)
    walk = robot().sensors["gyro"]["angle_random_walk"]
    std = {"gyro": walk * np.sqrt(RATE), "velocity": VELOCITY_STD, "joint": 2.5e-5}
    names = (*needed_columns(robot())[1:], *VELOCITY)
    columns, exact = {"t": t}, true.columns(robot())
    for name in names:
        noise = std.get(name.split(".")[0], 0.0) * random.standard_normal(t.size)
        columns[name] = exact[name] + noise
    return columns


def csv_lines(columns: dict[str, np.ndarray]) -> list[bytes]:
    """The header, then a line a sample; an empty cell where there is none."""
    rows = np.column_stack(list(columns.values())).tolist()
    return [",".join(columns).encode(), *map(csv_line, rows)]


def csv_line(row: Iterable[float]) -> bytes:
    return ",".join("" if np.isnan(x) else repr(x) for x in row).encode()


def json_lines(columns: dict[str, np.ndarray]) -> list[bytes]:
    rows = np.column_stack(list(columns.values())).tolist()
    return [
        json.dumps(dict(zip(columns, [None if np.isnan(x) else x for x in row])))
        .encode()
        for row in rows
    ]


def documents(text: str) -> list[dict]:
    """What `orbident live` printed."""
    return [json.loads(line) for line in text.splitlines()]


def stream_file(folder: Path, lines: list[bytes]) -> Path:
    path = folder / "stream"
    path.write_bytes(b"\n".join(lines) + b"\n")
    return path
