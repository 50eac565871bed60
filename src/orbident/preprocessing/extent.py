"""How far and how fast all moved: whether a recording excites what it should tell.

A long recording is gathered stretch by stretch.
"""

from typing import Annotated, NamedTuple

from pydantic import Field
from typing_extensions import TypedDict

from orbident.files.json_parts import FiniteNumber, NumberOrNone
from orbident.preprocessing.histories import Range, held_joints
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

NAMES = ("q", "qd", "qd_rw", "w")


class Extent(NamedTuple):
    """What all samples of a recording span."""

    start: float
    """s."""
    end: float
    """s."""
    rows: int
    ranges: dict[str, Range]
    """The extent of each signal, by the name of its field in `Samples`."""

    @classmethod
    def of(cls, samples: Samples) -> "Extent":
        """What these samples span."""
        ranges = {name: Range.of(getattr(samples, name)) for name in NAMES}
        t = samples.t
        return cls(float(t[0]), float(t[-1]), t.size, ranges)

    def and_of(self, other: "Extent") -> "Extent":
        """What both span, the other being later."""
        ranges = {n: each.and_of(other.ranges[n]) for n, each in self.ranges.items()}
        return Extent(self.start, other.end, self.rows + other.rows, ranges)

    def locked(self, robot: Robot) -> dict[str, float]:
        """The joints that did not move, and where they are held, rad or m."""
        dt = (self.end - self.start) / (self.rows - 1)
        return held_joints(robot, self.ranges["q"], self.ranges["qd"], dt)


Ends = Annotated[list[FiniteNumber], Field(min_length=2, max_length=2)] | None
"""The least and the largest; None where nothing was measured."""


class MovedJoint(TypedDict):
    """How far a joint moved and how fast; rad or m, and the same a second."""

    position: Ends
    rate: NumberOrNone


class MovedWheel(TypedDict):
    """How fast a wheel turned, rad/s."""

    speed: Ends


class MovedBase(TypedDict):
    """How fast the base turned about an axis, rad/s."""

    rate: NumberOrNone


class RecordedMotion(TypedDict):
    """How far and how fast all moved that was recorded; SI."""

    duration: FiniteNumber
    rate: FiniteNumber
    """Rows a second."""
    joints: dict[str, MovedJoint]
    wheels: dict[str, MovedWheel]
    base: dict[str, MovedBase]
    """By axis."""
    locked: list[str]
    """The joints that did not move."""


def motion_of(robot: Robot, extent: Extent, locked: tuple[str, ...]) -> RecordedMotion:
    """How far and how fast all moved.

    Args:
        robot: that was recorded.
        extent: of the samples.
        locked: the joints that did not move.
    """
    duration = extent.end - extent.start
    q, qd, qd_rw, w = (extent.ranges[name] for name in ("q", "qd", "qd_rw", "w"))
    return {
        "duration": duration,
        "rate": (extent.rows - 1) / duration,
        "joints": {
            name: {"position": q.ends(k), "rate": _fastest(qd, k)}
            for k, name in enumerate(robot.joint_names)
        },
        "wheels": {
            name: {"speed": qd_rw.ends(k)} for k, name in enumerate(robot.wheel_names)
        },
        "base": {axis: {"rate": _fastest(w, k)} for k, axis in enumerate("xyz")},
        "locked": list(locked),
    }


def _fastest(x: Range, k: int) -> float | None:
    both = x.ends(k)
    return None if both is None else max(abs(end) for end in both)
