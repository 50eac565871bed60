"""Is a sensor noisier than the robot file says, or does a gyro's bias wander?"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from orbident.estimation.causes.trial import Trial, trial
from orbident.estimation.output_error.sensors import INERTIAL, POINTS, scatter
from orbident.estimation.problem import MomentumProblem
from orbident.recordings.recording import Recording

NOISIER = 1.5
"""Times the declared noise."""

WANDERS = 100.0
"""Times the declared walk of a bias: what it needs is found by the fit."""


def noise(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again with the noise that neighbouring samples show."""
    sections = problem.robot.sensors
    found = dict(_noisier(problem))
    for name, (shown, declared, key) in found.items():
        amended = _with(problem, name, {key: shown * sections[name][key] / declared})
        words = (
            f"the noise of the {name} is {shown:.2g} (SI), {shown / declared:.2g} "
            "times what the robot file declares"
        )
        yield trial(words, amended)._replace(seen=True)


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
    found = trial(words, _with(problem, "gyro", walk))
    # So free a bias explains much that is none.
    if found.accepted:
        yield found


def _noisier(
    problem: MomentumProblem,
) -> Iterator[tuple[str, tuple[float, float, str]]]:
    recording, robot = problem.recording, problem.robot
    for name, section in robot.sensors.items():
        if not isinstance(section, dict):
            continue
        key = {**INERTIAL, **POINTS, "joints": "position"}.get(name)
        columns = _columns(problem, name)
        if key is None or not section.get(key) or columns is None:
            continue
        declared = section[key]
        if name in INERTIAL:
            declared = declared / np.sqrt(np.median(np.diff(recording.t)))
        shown = scatter(columns)
        if shown > NOISIER * declared:
            yield name, (shown, declared, key)


def _columns(problem: MomentumProblem, name: str) -> np.ndarray | None:
    """Of the sensor; of an attitude twice the quaternion's, which are angles."""
    recording: Recording = problem.recording
    if name == "joints":
        names = [f"joint.{joint}.position" for joint in problem.robot.joint_names]
    else:
        names = [f"{name}.{k}" for k in "xyz"]
    if not recording.has(*names):
        return None
    table = np.column_stack([recording.columns[column] for column in names])
    table = table[np.isfinite(table).all(axis=1)]
    return 2 * table if name == "attitude" else table


def _with(problem: MomentumProblem, name: str, changes: dict[str, Any]):
    robot = problem.robot
    sensors = {**robot.sensors, name: {**robot.sensors[name], **changes}}
    return problem.amended(robot=replace(robot, sensors=sensors))
