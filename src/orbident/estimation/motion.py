"""How far and how fast all moved: whether a recording excites what it should tell."""

from typing import Any

from orbident.estimation.extent import Extent, Range
from orbident.robot.description import Robot


def motion_of(robot: Robot, extent: Extent, locked: tuple[str, ...]) -> dict[str, Any]:
    """As in `result.json`; SI, None where nothing was measured.

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
