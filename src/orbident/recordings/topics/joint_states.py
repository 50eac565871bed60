"""sensor_msgs/JointState: joints and wheels by name."""

from collections.abc import Iterator, Mapping
from math import nan
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float
from pydantic import Field, model_validator

from orbident.errors import InputError
from orbident.recordings.topics.declared_units import Unit, unit
from orbident.recordings.topics.entry import Entry, Extraction, Name, Take, header_stamp

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
