"""The frames of an SDF model, and where each is.

A pose is relative to the frame that `relative_to` names. Where it names none, it is

- of a link, and of a frame that is attached to nothing: relative to the model's frame,
- of a frame: to the frame, link or joint that it is attached to,
- of a joint: to its child's frame,
- of the inertia: to the link's frame, always.
"""

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.bounds import SMALLEST
from orbident.files.names import quoted, suggestion
from orbident.robot.urdf import rotation_of
from orbident.robot.urdf_xml import numbers_in

MODEL = "__model__"
"""The name of the model's own frame."""

YES = ("true", "1")


class SdfPose(NamedTuple):
    """Where a frame is in another one."""

    R: Float[np.ndarray, "3 3"]
    p: Float[np.ndarray, "3"]

    def of(self, inner: "SdfPose") -> "SdfPose":
        """The pose in the outer frame of what has the pose `inner` in this one."""
        return SdfPose(self.R @ inner.R, self.p + self.R @ inner.p)

    def seen_from(self, other: "SdfPose") -> "SdfPose":
        """The pose in the frame `other`, which is given in the same outer frame."""
        return SdfPose(other.R.T @ self.R, other.R.T @ (self.p - other.p))


@dataclass(frozen=True)
class Frame:
    """A frame as the file gives it."""

    element: ET.Element
    default: str
    """The frame that its pose is relative to unless the pose says so."""
    attached: str | None = None
    """What a frame or a joint moves with; a link moves by itself."""


class Frames:
    """All frames of a model by name, and their poses."""

    def __init__(self, frames: dict[str, Frame], place: str) -> None:
        """Keep the frames of links, joints and frames; `place` is for messages."""
        self._frames, self._place = frames, place
        self._poses = {MODEL: SdfPose(np.eye(3), np.zeros(3))}

    def carrier(self, name: str, where: str) -> str:
        """What a frame is attached to in the end: a link, or a name that is none.

        Raises:
            InputError: it is attached to itself.
        """
        passed: list[str] = []
        while name in self._frames and self._frames[name].attached is not None:
            if name in passed:
                raise InputError(
                    f"{where}: {quoted(name)} is attached to itself; correct it"
                )
            passed.append(name)
            name = str(self._frames[name].attached)
        return name

    def pose(self, name: str) -> SdfPose:
        """The pose of a link, joint or frame in the model's frame.

        Raises:
            InputError: it is relative to itself or to what is not there, or no numbers.
        """
        chain: list[str] = []
        while name not in self._poses:
            if name in chain:
                raise InputError(
                    f"{self._place}: the pose of {quoted(name)} is relative to "
                    "itself; correct its relative_to"
                )
            if name not in self._frames:
                of = f"{quoted(chain[-1])} is" if chain else "an axis is"
                raise InputError(
                    f"{self._place}: {of} relative to {quoted(name)}, which is not in "
                    f"the file; {suggestion(name, self._frames, 'frames')}"
                )
            chain.append(name)
            frame = self._frames[name]
            pose = frame.element.find("pose")
            name = (None if pose is None else pose.get("relative_to")) or frame.default
        for each in reversed(chain):
            own = own_pose(self._frames[each].element, f"{self._place}: '{each}'")
            self._poses[each] = self._poses[name].of(own)
            name = each
        return self._poses[name]


def own_pose(element: ET.Element, where: str) -> SdfPose:
    """What the <pose> in an element says, relative to whatever it is relative to.

    Raises:
        InputError: it does not hold as many finite numbers as it should.
    """
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return SdfPose(np.eye(3), np.zeros(3))
    text, where = str(pose.text), f"{where}: <pose>"
    if pose.get("rotation_format") == "quat_xyzw":
        from scipy.spatial.transform import Rotation

        numbers = np.array(numbers_in(text, 7, where))
        if np.linalg.norm(numbers[3:]) < SMALLEST:
            raise InputError(f"{where}: the quaternion is zero; correct it")
        return SdfPose(Rotation.from_quat(numbers[3:]).as_matrix(), numbers[:3])
    numbers = np.array(numbers_in(text, 6, where))
    degrees = pose.get("degrees") in YES
    turned = np.radians(numbers[3:]) if degrees else numbers[3:]
    return SdfPose(rotation_of(turned), numbers[:3])
