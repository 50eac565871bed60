"""Is a sensor noisier than the robot file says, or does a gyro's bias wander?"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from orbident.diagnosis.shown import shown_by
from orbident.diagnosis.trial import Trial, amended_trial
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import INERTIAL, POINTS, scatter

NOISIER = 1.5
"""Times the declared noise."""

WANDERS = 100.0
"""Times the declared walk of a bias: what it needs is found by the fit."""


def noisier_sensors(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with the noise that neighbouring samples show."""
    tables = shown_by(problem.robot, problem.recording)
    joints = [x for name, x in tables.items() if name.startswith("joint.")]
    if joints:
        tables["joints"] = np.hstack(joints)
    for name, key in {**INERTIAL, **POINTS, "joints": "position"}.items():
        section = problem.robot.sensors.get(name) or {}
        if name not in tables or not section.get(key):
            continue
        x = tables[name][np.isfinite(tables[name]).all(axis=1)]
        # Of an attitude twice the quaternion's, which are angles.
        shown = scatter(2 * x if name == "attitude" else x)
        declared = section[key]
        if name in INERTIAL:
            declared = declared / np.sqrt(np.median(np.diff(problem.recording.t)))
        if shown > NOISIER * declared:
            words = (
                f"the noise of the {name} is {shown:.2g} (SI), {shown / declared:.2g} "
                "times what the robot file declares"
            )
            more = {key: shown * section[key] / declared}
            yield _trial(problem, name, words, more)._replace(seen=True)


def wandering(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with a gyro whose bias may walk freely."""
    gyro = problem.robot.sensors.get("gyro") or {}
    if not problem.recording.has("gyro.x") or not gyro.get("bias_instability"):
        return
    walk = {"bias_instability": WANDERS * gyro["bias_instability"]}
    words = (
        "the bias of the gyro drifts far more than the robot file declares: with one "
        "that may walk 100 times as far"
    )
    found = _trial(problem, "gyro", words, walk)
    # So free a bias explains much that is none.
    if found.accepted:
        yield found


def _trial(
    problem: MomentumProblem, name: str, words: str, changes: dict[str, Any]
) -> Trial:
    """The same problem with other noise of a sensor."""
    robot = problem.robot
    sensors = {**robot.sensors, name: {**robot.sensors[name], **changes}}
    return amended_trial(words, problem, replace(robot, sensors=sensors))
