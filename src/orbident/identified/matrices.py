"""`H+` and the Jacobians of an identified robot in one configuration, as JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.quantities import nulled
from orbident.estimation.result import Result
from orbident.files.names import listed, quoted

SCHEMA = "orbident/matrices/1"


def matrices_at(result: Result, q: Sequence[float]) -> dict[str, Any]:
    """`H+`, its standard deviations, and the Jacobian of each body's origin.

    Args:
        result: complete and not rejected.
        q: joint positions, rad or m.

    Raises:
        InputError: the result is rejected or not complete, or `q` is not a finite
            number for each joint.
    """
    robot, at = result.robot, np.array(q, dtype=float)
    if at.shape != (len(robot.joints),) or not np.isfinite(at).all():
        raise InputError(
            f"--q: found {quoted(list(q))}, expected {len(robot.joints)} finite "
            f"numbers, of {listed(robot.joint_names)}"
        )
    model = result.dynamics()
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "q": dict(zip(robot.joint_names, at.tolist(), strict=True)),
        "speeds": [
            *(f"v_cm.{k}" for k in "xyz"),
            *(f"w.{k}" for k in "xyz"),
            *robot.joint_names,
            *robot.wheel_names,
        ],
        "H_plus": _rows(model.H_plus(at)),
        "H_plus_std": _rows(model.H_plus_std(at)),
        "jacobians": {
            body: _rows(model.jacobian(at, body, np.zeros(3))) for body in robot.bodies
        },
    }


def _rows(matrix: np.ndarray) -> list[Any]:
    return [nulled(row) for row in matrix]
