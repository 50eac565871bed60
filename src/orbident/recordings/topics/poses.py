"""Poses and transforms: position of S, attitude of the base."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float

from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import (
    Extraction,
    Name,
    PlacedEntry,
    Take,
    header_stamp,
)
from orbident.recordings.topics.quaternions import conjugate, rotate_by_quaternion


class PoseTake(Take):
    """Either or both."""

    position: Annotated[Unit, unit("length")] | None = None
    attitude: Literal["quaternion"] | None = None


class Pose(PlacedEntry[PoseTake]):
    """A tracked body's pose, S its origin: `(x_WS, p_WS)`, or `(x_SW, p_SW)`."""

    pose: Literal["base-in-inertial", "inertial-in-base"]

    @property
    def quaternion(self) -> slice | None:
        """The orientation, needed for the position too where the pose is inverted."""
        inverted = self.pose == "inertial-in-base"
        return slice(0, 4) if self.take.attitude or inverted else None

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Orientation, position."""
        pose = message.pose
        # PoseWithCovarianceStamped has the pose in its pose.
        pose = getattr(pose, "pose", pose)
        yield Extraction(
            header_stamp(message.header), pose_values(pose.orientation, pose.position)
        )

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """Columns in m, inertial axes; `p_WS = -R_SW^T p_SW` of an inverted pose."""
        x_WS, p_WS = raw[:, :4], raw[:, 4:7]
        if self.pose == "inertial-in-base":
            x_WS = conjugate(x_WS)
            p_WS = -rotate_by_quaternion(x_WS, p_WS)
        parts = []
        if self.take.position:
            parts.append(p_WS * self.take.position.si)
        if self.take.attitude:
            parts.append(self.of_base(x_WS))
        return np.hstack(parts)


class Transform(Pose):
    """One of the transforms that come on a topic, by its two frames."""

    parent: Name
    child: Name

    @property
    def wanted(self) -> frozenset[str]:
        """The one transform."""
        return frozenset([f"{self.parent} -> {self.child}"])

    @staticmethod
    def labels(message: Any) -> tuple[str, ...]:
        """`parent -> child` of each."""
        return tuple(
            f"{each.header.frame_id} -> {each.child_frame_id}"
            for each in _transforms(message)
        )

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Rotation, translation of each that is between the two frames."""
        for each in _transforms(message):
            frames = each.header.frame_id, each.child_frame_id
            if frames == (self.parent, self.child):
                yield Extraction(
                    header_stamp(each.header),
                    pose_values(each.transform.rotation, each.transform.translation),
                )


def pose_values(x: Any, p: Any) -> tuple[float, ...]:
    """A message's quaternion and vector in a row."""
    return x.x, x.y, x.z, x.w, p.x, p.y, p.z


def _transforms(message: Any) -> list[Any]:
    """Those of a TFMessage, or the one TransformStamped."""
    return getattr(message, "transforms", [message])
