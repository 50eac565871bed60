"""Lines of text into samples: CSV with a header, or JSON objects, one a line.

Both name their columns as a recording does. What stands before the first header, and
what is neither, is counted and left out.
"""

import json
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.files.names import listed
from orbident.recordings.columns import VECTORS, meaning
from orbident.robot.description import Robot

VELOCITY = tuple(f"velocity.{axis}" for axis in "xyz")
LONGEST = 2**16
"""Bytes of a line: a stream without line ends would fill the memory."""


def needed_columns(robot: Robot) -> tuple[str, ...]:
    """The columns of a complete sample but for its velocity, `t` first."""
    vectors = {
        name: [f"{name}.{axis}" for axis in VECTORS[name][0]]
        for name in ("gyro", "attitude")
    }
    return (
        "t",
        *(f"joint.{name}.position" for name in robot.joint_names),
        *(f"joint.{name}.velocity" for name in robot.joint_names),
        *vectors["gyro"],
        *vectors["attitude"],
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


class Read(NamedTuple):
    """What some lines were."""

    samples: Float[np.ndarray, "n all"]
    """The time, then all that the filter takes."""
    unreadable: int
    """Lines that were neither a header nor a sample."""


class Lines:
    """Reads lines as they come; the header is what it remembers."""

    def __init__(self, robot: Robot, source: str) -> None:
        """Nothing has come yet.

        Args:
            robot: whose columns count.
            source: where the lines come from, for messages.
        """
        self._source = source
        self._needed = needed_columns(robot)
        first = 1 + 2 * len(robot.joints)
        # The gyro once more: nothing here smooths it without looking ahead.
        self._columns = (*self._needed, *VELOCITY, *self._needed[first : first + 3])
        self._cells = 0
        self._places: list[int] = []
        self.known = False
        """Whether a header, or an object with its columns, has come."""
        self.lacking = ""
        """What the first header, or object, lacked, and what to do."""

    def take(self, lines: Iterable[bytes]) -> Read:
        """The samples of some lines."""
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
        return Read(table, unreadable)

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
