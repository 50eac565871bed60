"""One run of `orbident live`: lines in, JSON documents out, and a state file.

The state is what is carried from sample to sample; its file is written whole or not at
all: a checksum, a line of JSON that says how many numbers follow, and these numbers.
All sizes are checked before anything is read that could be large.
"""

import hashlib
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field

from orbident._core import Watch
from orbident.errors import InputError
from orbident.estimation.recursive.filter import cad_prior
from orbident.estimation.recursive.filter_input import declared_noise
from orbident.files.replacing import replacing
from orbident.live.live_filter import (
    Carried,
    LiveEvent,
    LiveFilter,
    Running,
    Tools,
    begun,
    tools_of,
)
from orbident.live.sources import Lines, attitude_columns, complete, needed_columns
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
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
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


def read_state(path: Path | None, robot: Robot, velocity_std: float | None) -> Carried:
    """Read it back, or nothing where there is no such file, or none was named.

    The deviation of a velocity sample is in m/s.

    Raises:
        InputError: it is no such file, is damaged, or is of another robot or noise.
    """
    if path is None or not path.exists():
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
    tools: Tools, numbers: Float[np.ndarray, " n"], watched: Float[np.ndarray, " m"]
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


Sink = Callable[[dict[str, Any]], object]
"""Takes a document that can be written as JSON."""


class Session:
    """Lines in, documents out."""

    def __init__(
        self,
        robot: Robot,
        source: str,
        every: float,
        velocity_std: float | None,
        state: Path | None,
    ) -> None:
        """Go on from the state file, where there is one.

        Estimates are `every` s of the samples; the deviation of a velocity sample, m/s,
        is None where none counts.

        Raises:
            InputError: the state is damaged or of another robot, or the noise of the
                gyro is not declared.
        """
        # Before any sample: what is sent must not end the run.
        declared_noise(robot, 1.0, velocity_std)
        self._robot, self._state = robot, state
        carried = read_state(state, robot, velocity_std)
        self._lines = Lines(robot, source)
        self._filter = LiveFilter(robot, velocity_std, every, carried)
        self._source = source
        self._unreadable = self._unfinished = 0

    def start(self) -> dict[str, Any]:
        """The first document: names, formulas, and what is believed beforehand."""
        prior = cad_prior(self._robot)
        base = formulas_of(self._robot, minimal_sets(self._robot)).base
        resumed = self._filter.estimate()
        return {
            "event": "start",
            "robot": self._robot.name,
            "names": list(base.names),
            "formulas": list(base.formulas),
            "beta": prior.beta.tolist(),
            "std": np.linalg.norm(np.linalg.inv(prior.root), axis=1).tolist(),
            "resumed_at": None if resumed is None else resumed.t,
        }

    def take(self, lines: Sequence[bytes], sinks: Iterable[Sink]) -> None:
        """Take some lines in, and tell what they say.

        Raises:
            InputError: the state cannot be written.
        """
        self._unfinished = sum(bool(line.strip()) for line in lines)
        complete = not self._lines.lacking
        samples, unreadable = self._lines.take(lines)
        told = self._filter.take(samples)
        self._unreadable += unreadable
        self._unfinished = 0
        documents = [self._document(event) for event in told]
        if complete and self._lines.lacking and not self._lines.known:
            document = {"event": "unreadable", "t": None, "why": self._lines.lacking}
            documents.insert(0, document)
        for document in documents:
            for sink in sinks:
                sink(document)
        if any(event.kind == "estimate" for event in told):
            self._save()

    def end(self, sinks: Iterable[Sink], lost: int = 0, waiting: int = 0) -> None:
        """Tell what is known at last, and keep the state.

        The last message counts the datagrams `lost`, and the lines still `waiting`.

        Raises:
            InputError: what came gave no estimate, or the state cannot be written.
        """
        at, last = self._filter.carried, self._filter.estimate()
        counts = {
            **at.counts,
            "unreadable": self._unreadable,
            "waiting": at.waiting + self._unfinished + waiting,
        }
        document: dict[str, Any] = {"event": "end", "t": None}
        if last is not None:
            self._save()
            document |= self._document(last) | {"event": "end"}
        document |= {"counts": counts, "lost_datagrams": lost}
        for sink in sinks:
            sink(document)
        if not self._lines.known:
            found = (
                "no line names the columns" if self._unreadable else "no sample came"
            )
            raise InputError(
                self._lines.lacking
                or f"{self._source}: {found}; send a line such as "
                "'t,joint.joint1.position,..' first and then samples, or JSON objects"
            )
        if last is None:
            came = ", ".join(f"{n} {name}" for name, n in counts.items() if n)
            raise InputError(
                f"{self._source}: no estimate, since the filter begins with {WARM_UP} "
                f"complete samples, at most {PAUSE:g} s apart and in {ALONE:g} s or "
                f"more; found {came}; check what is sent, t is in seconds"
            )

    def _save(self) -> None:
        if self._state is not None:
            save_state(self._state, self._filter.carried)

    def _document(self, event: LiveEvent) -> dict[str, Any]:
        document = {"event": event.kind, "t": event.t, **event.of}
        if event.kind == "estimate":
            value, std = event.of["beta"][0], event.of["std"][0]
            told = event.of["scale"]
            document["mass"] = {"value": value, "std": std} if told else None
        return document
