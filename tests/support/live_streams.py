"""Streams of samples as a laboratory sends them: noisy, causal, one line a sample."""

import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
from captured_bodies import CapturedBody, holding, truth_through_change
from random_motions import random_motion

from orbident.live.sources import needed_columns
from orbident.recordings.columns import vector_columns
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import made_along, sample_times

NAME, DURATION, RATE = "paper-spatial", 30.0, 20.0
VELOCITY_STD = 1e-3
# On the axis of the last link, as what the robot file knows of it demands.
CAPTURED = CapturedBody(30.0, np.array([0.5, 0.0, 0.0]), np.diag([1.0, 1.5, 2.0]))


@cache
def robot() -> Robot:
    return load_robot(NAME)


@cache
def samples(captured_at: float | None = None) -> dict[str, np.ndarray]:
    """Columns by name, `t` among them."""
    return flown(DURATION, RATE, captured_at)


def flown(
    duration: float, rate: float, captured_at: float | None = None
) -> dict[str, np.ndarray]:
    """What a laboratory's own software sends of a flight."""
    motion, t = random_motion(robot(), duration=duration), sample_times(duration, rate)
    if captured_at is None:
        true = made_along(robot(), motion, rate).true
    else:
        held = holding(robot(), CAPTURED)
        true = truth_through_change(robot(), held, motion, captured_at, t)
    random = np.random.default_rng(0)
    walk = robot().sensors.of("gyro").white_std()
    std = {"gyro": walk * np.sqrt(rate), "velocity": VELOCITY_STD, "joint": 2.5e-5}
    columns, exact = {"t": t}, true.columns(robot())
    for name in (*needed_columns(robot())[1:], *vector_columns("velocity")):
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
    return [json_line(columns, row) for row in rows]


def json_line(columns: Iterable[str], row: Iterable[float]) -> bytes:
    named = zip(columns, row, strict=True)
    sample = {name: None if np.isnan(x) else x for name, x in named}
    return json.dumps(sample).encode()


def documents(text: str) -> list[dict]:
    """What `orbident live` printed."""
    return [json.loads(line) for line in text.splitlines()]


def stream_file(folder: Path, lines: list[bytes]) -> Path:
    path = folder / "stream"
    path.write_bytes(b"\n".join(lines) + b"\n")
    return path
