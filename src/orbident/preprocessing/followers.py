"""Joints that follow others, where encoders of both show one motion.

Equations would take the noise by which two encoders differ for a motion of the joints
apart. What only such a motion shows would seem to be measured, and be wrong. So all
follow the one that moves farthest, whose encoder shows most of their motion.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator

import numpy as np
from jaxtyping import Float

from orbident.gaussian import white_std
from orbident.preprocessing.histories import Lead
from orbident.recordings.recording import Recording
from orbident.robot.description import Coupling, Robot

ALIKE = 3.0
"""Times their noise that encoders may differ by and show one motion. Of a motion apart
that is hardly larger, noise shows as much as it does."""

FEWEST = 20
"""Samples of both joints that say how large noise is; with less they move as the robot
file says."""

MOST = 0.9
"""Over the samples of the joint that has most: who has less leads no other."""

SURE = 3.0
"""Deviations of its zero from which on an encoder is elsewhere."""

ROUNDING = 1e-12
"""Over a joint's motion: a column that another one gives differs by less from it."""


def one_motion(robot: Robot, recording: Recording) -> dict[str, Lead]:
    """The joints that move as others but for noise, and as which ones.

    Args:
        robot: whose couplings say what follows what.
        recording: of all joints, without what is no measurement, angles unwrapped.
    """
    groups = defaultdict[str, dict[str, Lead]](dict)
    samples = {
        name: np.isfinite(recording.column(_position(name))).sum()
        for name in robot.joint_names
    }
    for (follower, leader, factor, offset), apart in _together(robot, recording):
        if apart.size >= FEWEST:
            offset = float(np.median(apart))
        # Nobody measures what another column gives exactly.
        size = np.nanmax(np.abs(recording.column(_position(follower))), initial=0.0)
        if apart.size < FEWEST or np.ptp(apart) <= ROUNDING * size:
            samples[follower] = 0
        groups[leader][follower] = Lead(leader, factor, offset)
    found = dict[str, Lead]()
    for leader, each in groups.items():
        group = {leader: Lead(leader, 1.0, 0.0), **each}
        most = max(samples[name] for name in group)
        seen = [name for name in group if samples[name] >= MOST * most]
        head = max(seen, key=lambda name: abs(group[name].factor))
        _, farthest, shift = group.pop(head)
        for name, (_, factor, offset) in group.items():
            ratio = factor / farthest
            found[name] = Lead(head, ratio, offset - ratio * shift)
    return found


def encoders_elsewhere(robot: Robot, recording: Recording) -> Iterator[str]:
    """Followers whose encoders are elsewhere than the robot file says, in words.

    The arguments are those of `one_motion`.
    """
    zero = robot.tolerances.joint_zero
    for (follower, leader, factor, offset), apart in _together(robot, recording):
        if apart.size < FEWEST:
            continue
        off = float(np.median(apart)) - offset
        known = np.hypot(zero.get(follower, 0.0), factor * zero.get(leader, 0.0))
        if abs(off) > SURE * np.hypot(known, white_std(apart)):
            yield (
                f"column '{_position(follower)}' is {off:.3g} beside what the robot "
                f"file makes of joint '{leader}', more than encoders' zeros are off "
                "within tolerances: correct the column or the coupling's offset"
            )


def _together(
    robot: Robot, recording: Recording
) -> Iterator[tuple[Coupling, Float[np.ndarray, " n"]]]:
    """Couplings whose encoders show one motion, and what is between both, rad or m."""
    encoders = robot.sensors.joints
    declared = encoders.white_std() if encoders else 0.0
    for coupling in robot.couplings:
        q, leading = (recording.column(_position(name)) for name in coupling[:2])
        apart = q - coupling.factor * leading
        apart = apart[np.isfinite(apart)]
        if apart.size >= FEWEST:
            noise = max(white_std(apart), np.hypot(1, coupling.factor) * declared)
            if np.sqrt(np.mean((apart - np.median(apart)) ** 2)) > ALIKE * noise:
                continue
        yield coupling, apart


def without_followers(recording: Recording, led: Collection[str]) -> Recording:
    """The recording where encoders of these joints show nothing."""
    nothing = np.zeros(recording.t.size)
    return recording.with_columns(dict.fromkeys(map(_position, led), nothing))


def _position(joint: str) -> str:
    return f"joint.{joint}.position"
