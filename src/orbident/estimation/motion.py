"""How far and how fast all moved: whether a recording excites what it should tell."""

from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot


def motion_of(robot: Robot, samples: Samples) -> dict[str, Any]:
    """As in `result.json`; SI, None where nothing was measured.

    Args:
        robot: that was recorded.
        samples: of the recording.
    """
    duration = float(samples.t[-1] - samples.t[0])
    return {
        "duration": duration,
        "rate": (samples.t.size - 1) / duration,
        "joints": {
            name: {"position": _range(q), "rate": _fastest(qd)}
            for name, q, qd in zip(
                robot.joint_names, samples.q, samples.qd, strict=True
            )
        },
        "wheels": {
            name: {"speed": _range(speed)}
            for name, speed in zip(robot.wheel_names, samples.qd_rw, strict=True)
        },
        "base": {
            axis: {"rate": _fastest(w)}
            for axis, w in zip("xyz", samples.w, strict=True)
        },
        "locked": list(samples.locked),
    }


def _range(x: Float[np.ndarray, " samples"]) -> list[float] | None:
    known = x[np.isfinite(x)]
    return [float(known.min()), float(known.max())] if known.size else None


def _fastest(x: Float[np.ndarray, " samples"]) -> float | None:
    both = _range(x)
    return None if both is None else max(abs(end) for end in both)
