"""Where lines come from, standard input or datagrams, and what samples they hold.

Lines are CSV with a header, or JSON objects, one a line. Both name their columns as a
recording does. What stands before the first header, and what is neither, is counted and
left out.
"""

import json
import math
import os
import socket
import sys
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.recordings.columns import meaning, vector_columns
from orbident.robot.description import Robot

LONGEST = 2**16
"""Bytes of a line: a stream without line ends would fill the memory."""


def needed_columns(robot: Robot) -> tuple[str, ...]:
    """The columns of a complete sample but for its velocity, `t` first."""
    return (
        "t",
        *(f"joint.{name}.position" for name in robot.joint_names),
        *(f"joint.{name}.velocity" for name in robot.joint_names),
        *vector_columns("gyro"),
        *vector_columns("attitude"),
        *(f"wheel.{name}.speed" for name in robot.wheel_names),
    )


def attitude_columns(robot: Robot) -> slice:
    """Where a sample has its quaternion."""
    first = 1 + 2 * len(robot.joints) + 3
    return slice(first, first + 4)


def complete(samples: Float[np.ndarray, "n all"]) -> Bool[np.ndarray, " n"]:
    """Which samples, as `Lines` reads them, lack nothing but perhaps the velocity."""
    there = np.isfinite(samples)
    there[:, -6:-3] = True
    return np.logical_and.reduce(there, axis=1)


class Lines:
    """Reads lines as they come; the header is what it remembers."""

    def __init__(self, robot: Robot, source: str) -> None:
        """Nothing has come yet."""
        self._source = source
        self._needed = needed_columns(robot)
        # The gyro once more: nothing here smooths it without looking ahead.
        more = (*vector_columns("velocity"), *vector_columns("gyro"))
        self._columns = (*self._needed, *more)
        self._cells = 0
        self._places: list[int] = []
        self.known = False
        """Whether a header, or an object with its columns, has come."""
        self.lacking = ""
        """What the first header, or object, lacked, and what to do."""

    def take(self, lines: Iterable[bytes]) -> tuple[Float[np.ndarray, "n all"], int]:
        """The samples of some lines: the time, then all that the filter takes.

        Then how many lines were neither a header nor a sample.
        """
        samples, unreadable = [], 0
        for line in lines:
            text = line.strip()
            if not text:
                continue
            try:
                sample = self._one(text)
            except (ValueError, TypeError, OverflowError, RecursionError):
                unreadable += 1
                continue
            if sample is not None:
                samples.append(sample)
        table = np.array(samples, dtype=float).reshape(-1, len(self._columns))
        return table, unreadable

    def _one(self, text: bytes) -> list[float] | None:
        """One sample; none for a header."""
        if text.startswith(b"{"):
            return self._of_object(json.loads(text))
        cells = text.split(b",")
        if not self._places:
            self._read_header(text)
            return None
        if len(cells) != self._cells:
            raise ValueError
        cells.append(b"")
        try:
            return [float(cells[k]) if cells[k] else math.nan for k in self._places]
        except ValueError:
            self._read_header(text)
            return None

    def _of_object(self, values: dict[str, float | None]) -> list[float]:
        if not self.known:
            self._check(list(values))
        sample = [values.get(name) for name in self._columns]
        return [math.nan if value is None else float(value) for value in sample]

    def _read_header(self, text: bytes) -> None:
        names = [name.strip() for name in text.decode("utf-8-sig").split(",")]
        if "t" not in names:
            raise ValueError
        self._check(names)
        # One past the last cell stands for what no column gives.
        where = {name: place for place, name in enumerate(names)}
        self._places = [where.get(name, len(names)) for name in self._columns]
        self._cells = len(names)

    def _check(self, names: Sequence[str]) -> None:
        lacking = [name for name in self._needed if name not in names]
        if lacking:
            self.lacking = self.lacking or (
                f"{self._source}: found no column '{lacking[0]}' "
                f"({meaning(lacking[0])}) among {listed(names)}; send it with every "
                "sample: nothing is derived from later ones"
            )
            raise ValueError
        self.known = True


BLOCK = 2**16
"""Bytes that are taken at once, at most; no datagram is longer."""

ATONCE = 2**20
"""Bytes of datagrams that are taken at once, at most: a third of a second of 10 kHz."""

KERNEL = 2**22
"""Bytes that the system is asked to keep while the receiving thread does not run."""

WAITING = 2**26
"""Bytes that wait for the filter: of a kilohertz of a robot with few joints, more than
a minute."""

TOGETHER = 0.02
"""s: what comes in that time is taken at once. The rate is smoothed over a second of
samples, for twenty at once nearly as fast as for one."""

DROPS = 40
"""Linux's SO_RXQ_OVFL, which Python does not name: each datagram then comes with the
number of those that the system had no room for, in four bytes."""


def lines_of_input(given: TextIO | None) -> Iterator[list[bytes]]:
    """Whole lines as they come; of what comes faster than it is taken, many at once.

    Standard input that was closed before the command started is None.
    """
    if given is None:
        return
    handle, rest = given.fileno(), b""
    while block := os.read(handle, BLOCK):
        *lines, rest = (rest + block).split(b"\n")
        rest = rest[:LONGEST]
        if lines:
            yield lines
    if rest:
        yield [rest]


class Datagrams:
    """Lines of UDP datagrams.

    A thread of its own takes them from the system, so that a pause of the filter, or of
    the disk that its state is written to, loses none.
    """

    def __init__(self, host: str, port: int) -> None:
        """Listen.

        Raises:
            InputError: the host is no address of this machine, or the port is taken.
        """
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, KERNEL)
        if sys.platform == "linux":
            self._socket.setsockopt(socket.SOL_SOCKET, DROPS, 1)
        try:
            self._socket.bind((host, port))
        except (OSError, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"--udp: port {port} at '{host}' cannot be used ({reason}); give a "
                "free port, and with --host an address of this machine"
            ) from None
        self._waiting = bytearray()
        self._lock = threading.Lock()
        self._unseen = self._left_out = 0
        threading.Thread(target=self._receive, daemon=True).start()

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return int(self._socket.getsockname()[1])

    @property
    def lost(self) -> int:
        """Datagrams for which there was no room, here or in the system.

        The system tells only with the next datagram, and only Linux does.
        """
        return self._unseen + self._left_out

    @property
    def waiting(self) -> int:
        """Lines that have come and were not taken."""
        with self._lock:
            return sum(bool(line.strip()) for line in self._waiting.split(b"\n"))

    def lines(self) -> Iterator[list[bytes]]:
        """Lines as they come, without an end."""
        while True:
            time.sleep(TOGETHER)
            with self._lock:
                end = self._waiting.rfind(b"\n", 0, ATONCE) + 1
                block = bytes(self._waiting[:end])
                del self._waiting[:end]
            if block:
                yield block.split(b"\n")

    def _receive(self) -> None:
        while True:
            datagram, told, _, _ = self._socket.recvmsg(BLOCK, socket.CMSG_SPACE(4))
            for _, _, number in told:
                self._unseen = int.from_bytes(number, sys.byteorder)
            with self._lock:
                if len(self._waiting) + len(datagram) < WAITING:
                    self._waiting += datagram + b"\n"
                else:
                    self._left_out += 1
