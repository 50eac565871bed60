"""nav_msgs/Odometry: a pose, and a twist in the axes of either frame."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float
from pydantic import model_validator

from orbident.errors import InputError
from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import Extraction, PlacedEntry, Take, header_stamp
from orbident.recordings.topics.poses import pose_values
from orbident.recordings.topics.quaternions import conjugate, rotate_by_quaternion


class OdometryTake(Take):
    """Some of the four."""

    position: Annotated[Unit, unit("length")] | None = None
    attitude: Literal["quaternion"] | None = None
    velocity: Annotated[Unit, unit("velocity")] | None = None
    gyro: Annotated[Unit, unit("angular rate")] | None = None


class Odometry(PlacedEntry[OdometryTake]):
    """The child frame's pose `(x_WS, p_WS)` in the parent, which is inertial."""

    twist: Literal["child", "parent"] | None = None

    @model_validator(mode="after")
    def _twist_stated(self) -> "Odometry":
        if self.twist is None and {"velocity", "gyro"} & {*self.take.taken}:
            raise InputError(
                "twist missing; give 'twist: child' if the twist is in the child "
                "frame's axes, as the message's definition has it, or 'twist: parent'"
            )
        return self

    @property
    def quaternion(self) -> slice | None:
        """The orientation, needed to turn the twist too."""
        turned = (self.take.velocity and self.twist == "child") or (
            self.take.gyro and self.twist == "parent"
        )
        return slice(0, 4) if self.take.attitude or turned else None

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Orientation, position, velocity, angular velocity."""
        pose, twist = message.pose.pose, message.twist.twist
        v, w = twist.linear, twist.angular
        yield Extraction(
            header_stamp(message.header),
            (
                *pose_values(pose.orientation, pose.position),
                *(v.x, v.y, v.z, w.x, w.y, w.z),
            ),
        )

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """Columns, SI; `v_W = R_WS v_S`, `w_B = R_BS w_S` of a twist in child axes."""
        x_WS, p, v, w = np.split(raw, [4, 7, 10], axis=1)
        if self.twist == "child":
            v = rotate_by_quaternion(x_WS, v) if self.take.velocity else v
        else:
            w = rotate_by_quaternion(conjugate(x_WS), w) if self.take.gyro else w
        parts = []
        if self.take.position:
            parts.append(p * self.take.position.si)
        if self.take.attitude:
            parts.append(self.of_base(x_WS))
        if self.take.velocity:
            parts.append(v * self.take.velocity.si)
        if self.take.gyro:
            parts.append(self.in_base(w) * self.take.gyro.si)
        return np.hstack(parts)
