"""Messages of ROS that a topic map can take, an entry a kind.

sensor_msgs/Imu: gyro, accelerometer, attitude.

sensor_msgs/JointState: joints and wheels by name.

nav_msgs/Odometry: a pose, and a twist in the axes of either frame.

Poses and transforms: position of S, attitude of the base.

geometry_msgs/WrenchStamped: the thrusters' net force and moment.
"""

from collections.abc import Iterator, Mapping
from math import nan
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float
from pydantic import Field, model_validator

from orbident.errors import InputError
from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import (
    Entry,
    Extraction,
    Name,
    PlacedEntry,
    Take,
    conjugate,
    header_stamp,
    rotate_by_quaternion,
)


class ImuTake(Take):
    """Some of the three."""

    gyro: Annotated[Unit, unit("angular rate")] | None = None
    accelerometer: Annotated[Unit, unit("acceleration")] | None = None
    attitude: Literal["quaternion"] | None = None


class Imu(PlacedEntry[ImuTake]):
    """`w_B = R_BS w_S`, `f_B = R_BS f_S`, `R_WB = R_WS R_BS^T`."""

    @property
    def quaternion(self) -> slice | None:
        """The sensor's orientation, which many units leave zero."""
        return slice(0, 4) if self.take.attitude else None

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Orientation, angular velocity, specific force."""
        x, w, f = (
            message.orientation,
            message.angular_velocity,
            message.linear_acceleration,
        )
        yield Extraction(
            header_stamp(message.header),
            (x.x, x.y, x.z, x.w, w.x, w.y, w.z, f.x, f.y, f.z),
        )

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI and base axes."""
        parts = []
        if self.take.gyro:
            parts.append(self.in_base(raw[:, 4:7]) * self.take.gyro.si)
        if self.take.accelerometer:
            parts.append(self.in_base(raw[:, 7:10]) * self.take.accelerometer.si)
        if self.take.attitude:
            parts.append(self.of_base(raw[:, :4]))
        return np.hstack(parts)


_RATE_OF = {"angle": "angular rate", "length": "velocity"}


class JointTake(Take):
    """Positions, velocities, or both."""

    position: Annotated[Unit, unit("angle", "length")] | None = None
    velocity: Annotated[Unit, unit("angular rate", "velocity")] | None = None


class JointStates(Entry):
    """`joints` and `wheels` say which name in the messages is which of the robot."""

    take: JointTake
    joints: Mapping[Name, Name] = Field(default_factory=dict)
    wheels: Mapping[Name, Name] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one_kind(self) -> "JointStates":
        position, velocity = self.take.position, self.take.velocity
        if not self.joints and not self.wheels:
            raise InputError(
                "joints and wheels missing; give the names in the messages and the "
                "robot's, such as joints: {shoulder: joint1}"
            )
        if position and velocity and _RATE_OF[position.dimension] != velocity.dimension:
            raise InputError(
                f"take: {position.name} and {velocity.name} are not of one kind of "
                "joint; give revolute and prismatic joints an entry each"
            )
        linear = {"length", "velocity"} & {u.dimension for u in self._units}
        if linear and self.wheels:
            raise InputError(
                "wheels cannot be in units of length; give them their own entry"
            )
        return self

    @property
    def _units(self) -> list[Unit]:
        return [u for u in (self.take.position, self.take.velocity) if u]

    @property
    def _sources(self) -> tuple[str, ...]:
        return (*self.joints, *self.wheels)

    @property
    def columns(self) -> tuple[str, ...]:
        """All positions, then all velocities."""
        names = []
        for key, speed in (("position", "position"), ("velocity", "speed")):
            if key in self.take.taken:
                names += [f"joint.{name}.{key}" for name in self.joints.values()]
                names += [f"wheel.{name}.{speed}" for name in self.wheels.values()]
        return tuple(names)

    @property
    def wanted(self) -> frozenset[str]:
        """The joints' names in the messages."""
        return frozenset(self._sources)

    @staticmethod
    def labels(message: Any) -> tuple[str, ...]:
        """The joints' names."""
        return tuple(message.name)

    def samples(self, message: Any) -> Iterator[Extraction]:
        """One, in the order of the columns; NaN where there is no value."""
        place = {name: k for k, name in enumerate(message.name)}
        values = []
        for key in self.take.taken:
            given = getattr(message, key).tolist()
            for name in self._sources:
                k = place.get(name, len(given))
                values.append(given[k] if k < len(given) else nan)
        yield Extraction(header_stamp(message.header), values)

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI."""
        return raw * np.repeat([u.si for u in self._units], len(self._sources))


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


class WrenchTake(Take):
    """Either or both."""

    force: Annotated[Unit, unit("force")] | None = None
    torque: Annotated[Unit, unit("torque")] | None = None


class WrenchStamped(PlacedEntry[WrenchTake]):
    """`f_B = R_BS f_S`, `n_B = R_BS n_S`, the moment about S."""

    def samples(self, message: Any) -> Iterator[Extraction]:
        """Force, torque."""
        f, n = message.wrench.force, message.wrench.torque
        yield Extraction(header_stamp(message.header), (f.x, f.y, f.z, n.x, n.y, n.z))

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI and base axes."""
        parts = []
        if self.take.force:
            parts.append(self.in_base(raw[:, :3]) * self.take.force.si)
        if self.take.torque:
            parts.append(self.in_base(raw[:, 3:]) * self.take.torque.si)
        return np.hstack(parts)
