"""What is carried from sample to sample, in a file: written whole or not at all.

A checksum, a line of JSON that says how many numbers follow, and these numbers. All
sizes are checked before anything is read that could be large.
"""

import hashlib
import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field

from orbident._core import Watch
from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.live.live_filter import Carried
from orbident.live.running import Running, Tools, begun, tools_of
from orbident.live.sources import attitude_columns, complete, needed_columns
from orbident.live.stream_clocks import (
    ALONE,
    CLOCKS,
    DIGITS,
    PAUSE,
    RATE,
    WARM_UP,
    StreamClock,
    StreamClocks,
)
from orbident.robot.description import Robot

LINE = 2**12
"""Bytes of the first two lines, at most: a name and a number for each kind of count."""

ROWS = round(ALONE * RATE) + WARM_UP + 1
"""Samples that wait for one thing are no more."""

NUMBER = np.dtype("<f8")


class LiveState(BaseModel):
    """What the numbers are that follow."""

    model_config: ClassVar[ConfigDict] = ConfigDict(extra="forbid", strict=True)

    kind: Literal["orbident live state 1"] = "orbident live state 1"
    dt: Annotated[float, Field(ge=10**-DIGITS, le=PAUSE)] | None
    """From sample to sample as sent, s; none before the filter has begun."""
    mark: str
    """Of the robot and of all that the filter is made of."""
    counts: dict[str, Annotated[int, Field(ge=0)]]
    rows: Annotated[
        list[Annotated[int, Field(ge=0, le=ROWS)]],
        Field(min_length=2, max_length=2 + CLOCKS),
    ]
    """How many samples went through, wait, and wait of each other clock."""


def save_state(path: Path, carried: Carried) -> None:
    """Write all of it; a restart goes on with the same bits.

    Raises:
        InputError: the place cannot be written.
    """
    clocks, running = carried.clocks, carried.running
    others = clocks.others
    tables = [carried.past, carried.held, *(np.array(each.rows) for each in others)]
    every = [clocks.believed or StreamClock(np.nan), *others]
    times = [carried.zero, carried.begin, carried.before, carried.due]
    times += [x for each in every for x in (each.first, each.newest, each.together)]
    numbers = [np.array(times), *tables]
    if running is not None:
        numbers += [running.state.numbers, running.watch.numbers]
    head = LiveState(
        dt=None if running is None else running.tools.dt,
        mark="" if running is None else running.tools.mark,
        counts=dict(carried.counts),
        rows=[len(table) for table in tables],
    )
    body = np.concatenate([each.ravel() for each in numbers]).astype(NUMBER).tobytes()
    content = head.model_dump_json().encode() + b"\n" + body
    checksum = hashlib.sha256(content).hexdigest().encode()
    with replacing(path) as temporary:
        temporary.write_bytes(checksum + b"\n" + content)


def nothing_carried(robot: Robot) -> Carried:
    """Before the first sample."""
    nothing = np.empty((0, len(needed_columns(robot)) + 6))
    return Carried(nothing, nothing, StreamClocks(attitude_columns(robot)))


def read_state(path: Path, robot: Robot, velocity_std: float | None) -> Carried:
    """Read it back, or nothing where there is no such file.

    Args:
        path: of the file.
        robot: whose it is.
        velocity_std: of a velocity sample, m/s.

    Raises:
        InputError: it is no such file, is damaged, or is of another robot or noise.
    """
    if not path.exists():
        return nothing_carried(robot)
    try:
        return _read(path, robot, velocity_std)
    except InputError:
        raise
    except (OSError, ValueError, np.linalg.LinAlgError):
        raise InputError(
            f"{path}: is no state of a filter, or is damaged; name another file, or "
            "remove this one to begin anew"
        ) from None


def _read(path: Path, robot: Robot, velocity_std: float | None) -> Carried:
    if not path.is_file():
        raise ValueError
    carried, tools = nothing_carried(robot), None
    columns = carried.held.shape[1]
    with path.open("rb") as file:
        checksum, line = file.readline(LINE), file.readline(LINE)
        head = LiveState.model_validate_json(line)
        sizes = [4, 3 * (len(head.rows) - 1), *(columns * rows for rows in head.rows)]
        if head.dt is not None:
            tools = tools_of(robot, head.dt, velocity_std)
            if head.mark != tools.mark:
                raise InputError(_another(path))
            fresh = begun(tools, np.zeros(columns))
            sizes += [fresh.state.numbers.size, fresh.watch.numbers.size]
        left = os.fstat(file.fileno()).st_size - file.tell()
        if left != NUMBER.itemsize * sum(sizes):
            raise InputError(_another(path)) if tools is None else ValueError
        body = file.read(left)
    if hashlib.sha256(line + body).hexdigest().encode() + b"\n" != checksum:
        raise ValueError
    parts = np.split(np.frombuffer(body, NUMBER), np.cumsum(sizes)[:-1])
    carried.counts.update(head.counts)
    _put(carried, columns, parts, tools)
    return carried


def _put(
    carried: Carried, columns: int, parts: list[np.ndarray], tools: Tools | None
) -> None:
    """Put what the file holds in its places."""
    if tools is not None:
        carried.running = _running(tools, *parts[-2:])
        parts = parts[:-2]
    times, clocks, *tables = parts
    carried.past, carried.held, *others = (
        _samples(table.reshape(-1, columns)) for table in tables
    )
    carried.zero, carried.begin, carried.before, carried.due = times.tolist()
    own, *rest = clocks.reshape(-1, 3)
    carried.clocks.others = list(map(_clock, rest, others))
    if tools is not None:
        carried.clocks.believed = replace(_clock(own, carried.held), rows=[])
        # An estimate may never be due again.
        if not np.isfinite(times[:-1]).all():
            raise ValueError


def _running(
    tools: Tools,
    numbers: Float[np.ndarray, " n"],
    watched: Float[np.ndarray, " m"],
) -> Running:
    rows, window = tools.detector.rows, tools.detector.window
    state = tools.kalman.core.restored(numbers)
    running = Running(tools, state, Watch.restored(rows, window, watched))
    with np.errstate(over="ignore"):
        std = running.std
    if not np.isfinite([*state.beta, *std]).all():
        raise ValueError
    return running


def _samples(rows: Float[np.ndarray, "n all"]) -> Float[np.ndarray, "n all"]:
    """As they were taken: complete, and each later than the one before."""
    if not (complete(rows).all() and (np.diff(rows[:, 0]) > 0).all()):
        raise ValueError
    return rows


def _clock(
    numbers: Float[np.ndarray, "3"], rows: Float[np.ndarray, "n all"]
) -> StreamClock:
    first, newest, together = numbers.tolist()
    if not (len(rows) and np.isfinite(numbers).all() and together >= 1):
        raise ValueError
    return StreamClock(first, newest, int(together), [row.copy() for row in rows])


def _another(path: Path) -> str:
    return (
        f"{path}: is the state of another robot, or of other sensors or another "
        "--velocity-std; name another file, or remove this one to begin anew"
    )
