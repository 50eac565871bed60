"""Messages of ROS that a topic map can take: where each has its vectors.

A message of vectors is a table of one row, and what is known of it is data. Two need
more: a pose may be that of the inertial frame in the base, and a twist may be in the
axes of either frame. Joints are found by their names.
"""

from collections.abc import Iterator, Mapping
from functools import cached_property
from math import nan
from operator import attrgetter
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float
from pydantic import Field, create_model, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import Name
from orbident.model.rotations import quaternion_matrix, rotate, rotate_back
from orbident.recordings.columns import VECTORS
from orbident.recordings.topics.any_message import Message
from orbident.recordings.topics.entry import Entry, Extraction, Take, header_stamp
from orbident.recordings.topics.fields import Filling
from orbident.recordings.topics.targets import (
    DIMENSION_OF,
    Target,
    Unit,
    conjugate,
    target_of,
    unit,
)


class VectorMessage(Filling):
    """Whole vectors of a message that has a stamp."""

    take: Take

    @property
    def targets(self) -> list[Target]:
        """What is filled, in the order of `PATHS`."""
        given = self.take.taken.items()
        return [target_of(name, getattr(u, "name", u)) for name, u in given]

    @property
    def turned_by_attitude(self) -> bool:
        """Whether the orientation is needed although it may not be taken."""
        return False

    @property
    def read(self) -> list[Target]:
        """What is read of a message, the orientation last where it is only needed."""
        needed = self.turned_by_attitude and "attitude" not in self.take.taken
        return [*self.targets, *([target_of("attitude", "quaternion")] * needed)]

    @cached_property
    def _values(self) -> attrgetter:
        paths = PATHS[self.type]
        names = [f"{paths[t.name]}.{k}" for t in self.read for k in VECTORS[t.name][0]]
        return attrgetter("header", *names)

    def samples(self, message: Any) -> Iterator[Extraction]:
        """One, whose numbers are in the order of `read`."""
        header, *values = self._values(message)
        yield header_stamp(header), values


class Odometry(VectorMessage):
    """The child frame's pose `(x_WS, p_WS)` in the parent, which is inertial."""

    twist: Literal["child", "parent"] | None = None

    @model_validator(mode="after")
    def _twist_stated(self) -> "Odometry":
        if self.twist is None and {"velocity", "gyro"} & self.take.taken.keys():
            raise InputError(
                "twist missing; give 'twist: child' if the twist is in the child "
                "frame's axes, as the message's definition has it, or 'twist: parent'"
            )
        return self

    @property
    def _turned(self) -> str:
        return "velocity" if self.twist == "child" else "gyro"

    @property
    def turned_by_attitude(self) -> bool:
        """Whether a part of the twist is not in the axes of its column."""
        return self._turned in self.take.taken

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """Columns, SI; `v_W = R_WS v_S`, `w_B = R_BS w_S` of a twist in child axes."""
        if self.turned_by_attitude:
            x, part = raw[:, self.slices["attitude"]], raw[:, self.slices[self._turned]]
            R = quaternion_matrix(x)
            part[:] = rotate(R, part) if self.twist == "child" else rotate_back(R, part)
        return super().table(raw)


class Pose(VectorMessage):
    """A tracked body's pose, S its origin: `(x_WS, p_WS)`, or `(x_SW, p_SW)`."""

    pose: Literal["base-in-inertial", "inertial-in-base"]

    @property
    def turned_by_attitude(self) -> bool:
        """Whether the pose is inverted."""
        return self.pose == "inertial-in-base"

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """Columns in m, inertial axes; `p_WS = -R_SW^T p_SW` of an inverted pose."""
        if self.turned_by_attitude:
            x = raw[:, self.slices["attitude"]]
            if "position" in self.slices:
                p = raw[:, self.slices["position"]]
                p[:] = -rotate_back(quaternion_matrix(x), p)
            x[:] = conjugate(x)
        return super().table(raw)


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
        """One of each that is between the two frames."""
        for each in _transforms(message):
            if (each.header.frame_id, each.child_frame_id) == (self.parent, self.child):
                yield from super().samples(each)


def _transforms(message: Any) -> list[Any]:
    """Those of a TFMessage, or the one TransformStamped."""
    return getattr(message, "transforms", [message])


_RATE_OF = {"angle": "angular rate", "length": "velocity"}


class JointTake(Take):
    """Positions, velocities, efforts, or some of them."""

    position: Annotated[Unit, unit("angle", "length")] | None = None
    velocity: Annotated[Unit, unit("angular rate", "velocity")] | None = None
    effort: Annotated[Unit, unit("torque", "force", "current")] | None = None


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
        linear = {"length", "velocity"} & {
            u.dimension for u in self.take.taken.values()
        }
        if linear and self.wheels:
            raise InputError(
                "wheels cannot be in units of length; give them their own entry"
            )
        if self.take.effort and self.wheels:
            raise InputError(
                "take: efforts are torques or currents of joints; give wheels an entry "
                "of their own"
            )
        return self

    @property
    def _sources(self) -> tuple[str, ...]:
        return (*self.joints, *self.wheels)

    @property
    def columns(self) -> tuple[str, ...]:
        """All positions, then all velocities, then all torques or currents."""
        effort, names = self.take.effort, []
        drive = "current" if effort and effort.dimension == "current" else "torque"
        for key, own, speed in (
            ("position", "position", "position"),
            ("velocity", "velocity", "speed"),
            ("effort", drive, ""),
        ):
            if key in self.take.taken:
                names += [f"joint.{name}.{own}" for name in self.joints.values()]
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
        index = {name: k for k, name in enumerate(message.name)}
        values = []
        for key in self.take.taken:
            given = getattr(message, key).tolist()
            for name in self._sources:
                k = index.get(name, len(given))
                values.append(given[k] if k < len(given) else nan)
        yield header_stamp(message.header), values

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI."""
        si = [u.si for u in self.take.taken.values()]
        return raw * np.repeat(si, len(self._sources))


_POSE = {"position": "pose.position", "attitude": "pose.orientation"}
_TRANSFORM = {"position": "transform.translation", "attitude": "transform.rotation"}
_OF_COVARIANCE = {name: f"pose.{path}" for name, path in _POSE.items()}

PATHS: Mapping[str, Mapping[str, str]] = {
    "sensor_msgs/Imu": {
        "gyro": "angular_velocity",
        "accelerometer": "linear_acceleration",
        "attitude": "orientation",
    },
    "geometry_msgs/PoseStamped": _POSE,
    "geometry_msgs/PoseWithCovarianceStamped": _OF_COVARIANCE,
    "geometry_msgs/TransformStamped": _TRANSFORM,
    "tf2_msgs/TFMessage": _TRANSFORM,
    "nav_msgs/Odometry": {
        **_OF_COVARIANCE,
        "velocity": "twist.twist.linear",
        "gyro": "twist.twist.angular",
    },
    "geometry_msgs/WrenchStamped": {"force": "wrench.force", "torque": "wrench.torque"},
}
"""Where a message has the vectors that can be taken of it."""


def _with_keys(
    kind: type[VectorMessage], names: Mapping[str, str]
) -> type[VectorMessage]:
    """The entry of a message from which these can be taken."""
    units: dict[str, Any] = {
        name: Annotated[Unit, unit(of)] for name, of in DIMENSION_OF.items()
    }
    units["attitude"] = Literal["quaternion"]
    keys: dict[str, Any] = {name: (units[name] | None, None) for name in names}
    take = create_model("VectorTake", __base__=Take, **keys)
    return create_model(kind.__name__, __base__=kind, take=(take, ...))


_KINDS: Mapping[str, type[VectorMessage]] = {
    "geometry_msgs/PoseStamped": Pose,
    "geometry_msgs/PoseWithCovarianceStamped": Pose,
    "geometry_msgs/TransformStamped": Transform,
    "tf2_msgs/TFMessage": Transform,
    "nav_msgs/Odometry": Odometry,
}

MESSAGE_TYPES: Mapping[str, type[Entry]] = {
    "sensor_msgs/JointState": JointStates,
    **{
        name: _with_keys(_KINDS.get(name, VectorMessage), paths)
        for name, paths in PATHS.items()
    },
    "std_msgs/Float64": Message,
}
"""The messages that can be mapped without `fields`."""
