"""Joints that follow others, where encoders of both show one motion.

Equations would take the noise by which two encoders differ for a motion of the joints
apart. What only such a motion shows would seem to be measured, and be wrong. So all
follow the one that moves farthest, whose encoder shows most of their motion.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from orbident.gaussian import white_std
from orbident.preprocessing.histories import Histories
from orbident.recordings.recording import Recording
from orbident.robot.description import Coupling, Robot

ALIKE = 1.5
"""Times their noise that encoders may differ by and show one motion. How large noise is
shows to some percent, and play or a spring between the joints makes more of it."""

FEWEST = 20
"""Samples of both joints that say how large noise is."""

ROUNDING = 1e-12
"""Over a joint's motion: a column that another one gives differs by less from it."""


class Lead(NamedTuple):
    """How one joint moves another: `q = factor q' + offset`, rad or m."""

    by: str
    factor: float
    offset: float


def one_motion(robot: Robot, recording: Recording) -> dict[str, Lead]:
    """The joints that move as others but for noise, and as which ones.

    Args:
        robot: whose couplings say what follows what.
        recording: of all joints, without what is no measurement, angles unwrapped.
    """
    groups = defaultdict[str, dict[str, Lead]](dict)
    measured = {name: True for name in robot.joint_names}
    for coupling in robot.couplings:
        q = recording.column(_position(coupling.follower))
        apart = q - coupling.factor * recording.column(_position(coupling.leader))
        apart = apart[np.isfinite(apart)]
        if apart.size < FEWEST or not _noise_alone(robot, coupling, apart):
            continue
        measured[coupling.follower] = np.ptp(apart) > ROUNDING * np.nanmax(np.abs(q))
        groups[coupling.leader][coupling.follower] = Lead(
            coupling.leader, coupling.factor, float(np.median(apart))
        )
    found = dict[str, Lead]()
    for leader, each in groups.items():
        group = {leader: Lead(leader, 1.0, 0.0), **each}
        seen = [name for name in group if measured[name]]
        head = max(seen, key=lambda name: abs(group[name].factor))
        _, farthest, shift = group.pop(head)
        for name, (_, factor, offset) in group.items():
            ratio = factor / farthest
            found[name] = Lead(head, ratio, offset - ratio * shift)
    return found


def _noise_alone(robot: Robot, coupling: Coupling, apart: np.ndarray) -> bool:
    encoders = robot.sensors.joints
    declared = encoders.white_std() if encoders else 0.0
    noise = max(float(white_std(apart)), float(np.hypot(1, coupling.factor)) * declared)
    off = apart - np.median(apart)
    return bool(np.sqrt(np.mean(off**2)) <= ALIKE * noise)


def as_one_motion(
    robot: Robot, joints: Histories, led: Mapping[str, Lead]
) -> Histories:
    """The histories with these joints as those that they follow move them."""
    at = {name: k for k, name in enumerate(robot.joint_names)}
    q, qd = list(joints.positions), list(joints.rates)
    shares, worst = list(joints.shares), list(joints.worst)
    for name, (leader, factor, offset) in led.items():
        k, other = at[name], at[leader]
        q[k], qd[k] = factor * q[other] + offset, factor * qd[other]
        of_q, of_qd = worst[other]
        worst[k] = abs(factor) * of_q, abs(factor) * of_qd
        shares[k] = shares[other]
    return joints._replace(
        positions=tuple(q), rates=tuple(qd), shares=tuple(shares), worst=tuple(worst)
    )


def without_followers(recording: Recording, led: Collection[str]) -> Recording:
    """The recording where encoders of these joints show nothing."""
    nothing = np.zeros(recording.t.size)
    return recording.with_columns(dict.fromkeys(map(_position, led), nothing))


def _position(joint: str) -> str:
    return f"joint.{joint}.position"
