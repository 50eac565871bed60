"""What every entry of a topic map has: a topic, its clock, and what is taken."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import (
    MappingSchema,
    Name,
    WrongValueError,
    finite_number,
    finite_vector,
)
from orbident.model.rotations import quaternion_matrix, rotate

Quaternions = Float[np.ndarray, "#n 4"]
Vectors = Float[np.ndarray, "#n 3"]


def product(x: Quaternions, y: Quaternions) -> Quaternions:
    """`R(x y) = R(x) R(y)`."""
    u, v = x[:, :3], y[:, :3]
    a, b = x[:, 3:], y[:, 3:]
    vector = a * v + b * u + np.cross(u, v)
    scalar = a * b - np.sum(u * v, axis=1, keepdims=True)
    return np.concatenate([vector, scalar], axis=1)


def conjugate(x: Quaternions) -> Quaternions:
    """`R(x*) = R(x)^T`."""
    return x * np.array([-1.0, -1.0, -1.0, 1.0])


LONGEST = 2**62
"""ns, 146 years; so far the sum of a time's fields goes, and its offset."""
TURNED = {"gyro", "accelerometer", "attitude", "force", "torque"}
"""What is in, or of, the base's axes."""
AT_S = {"accelerometer", "position", "velocity", "torque"}
"""What is of the feature point, or about it."""


class Extraction(NamedTuple):
    """What an entry takes from one message."""

    stamp: int | None
    """The header's, ns; None for a type without a header."""
    values: Sequence[float]
    """As they are in the message; NaN where it has none."""


def header_stamp(header: Any) -> int:
    """A header's stamp, ns; 0 of what is none."""
    stamp: Any = getattr(header, "stamp", None)
    if not (hasattr(stamp, "sec") and hasattr(stamp, "nanosec")):
        return 0
    return stamp.sec * 1_000_000_000 + stamp.nanosec


class Take(MappingSchema):
    """What is taken from a message, each with its unit."""

    @model_validator(mode="after")
    def _something(self) -> "Take":
        if not self.taken:
            raise InputError(
                f"nothing is taken; give some of {', '.join(self._keys())}"
            )
        return self

    @property
    def taken(self) -> tuple[str, ...]:
        """The keys that are given."""
        return tuple(key for key, value in self if value is not None)


def _offset(value: object) -> float:
    offset = finite_number(value)
    if abs(offset) * 1e9 > LONGEST:
        raise WrongValueError("give at most 146 years, in s")
    return offset


class Entry(MappingSchema):
    """One entry: how a topic's messages become columns."""

    topic: Name
    type: str
    clock: Name | None = None
    time: Literal["header", "receive"] = "header"
    offset: Annotated[float, BeforeValidator(_offset)] = 0.0
    """s, added to its times: by how much its clock is behind."""
    other_time: ClassVar[str] = "receive"
    """What the time is called that is none of a header."""

    @property
    def sender_time(self) -> str:
        """What the sender's time is called."""
        return "header"

    @property
    def counts(self) -> tuple[int, ...]:
        """ns, what the counter of its times may count."""
        return (1,)

    @property
    @abstractmethod
    def columns(self) -> tuple[str, ...]:
        """The recording's columns that it fills."""

    @property
    def wanted(self) -> frozenset[str]:
        """Labels (names of joints, of transforms) that messages must have."""
        return frozenset()

    @property
    def quaternion(self) -> slice | None:
        """Where in a sample's values a unit quaternion stands, if one is used."""
        return None

    @staticmethod
    def labels(message: Any) -> tuple[str, ...]:
        """The labels that a message has."""
        return ()

    def samples(self, message: Any) -> Iterator[Extraction]:
        """What a message holds; nothing of a table, whose rows come as arrays."""
        return iter(())

    def lacked(self, message: Any, column: str) -> str:
        """What a message lacks of a column, in words; empty if that is nothing."""
        return ""

    @abstractmethod
    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """Samples' values, their quaternions of length one, as columns in SI."""


def _rotation(value: object) -> tuple[float, ...]:
    quaternion = finite_vector(value, 4)
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1) > 0.01:
        raise InputError(f"its norm is {norm:.4g}; give a unit quaternion, scalar last")
    return tuple(each / norm for each in quaternion)


class Mounted(Entry):
    """A sensor that is turned against the base, `x_BS`, and may be at S."""

    frame: Literal["base"] | None = None
    rotation: (
        Annotated[tuple[float, float, float, float], BeforeValidator(_rotation)] | None
    ) = None
    point: Literal["S"] | None = None

    @property
    @abstractmethod
    def sensors(self) -> tuple[str, ...]:
        """What is taken, as `VECTORS` names it."""

    @model_validator(mode="after")
    def _stated(self) -> "Mounted":
        turned = [each for each in self.sensors if each in TURNED]
        if turned and (self.frame is None) == (self.rotation is None):
            found = "neither" if self.frame is None else "both"
            raise InputError(
                f"{found} of frame and rotation given for {', '.join(turned)}; give "
                "'frame: base' if the axes are the base's, else 'rotation: [x, y, z, "
                "w]', which turns vectors from the sensor's axes to the base's"
            )
        placed = [each for each in self.sensors if each in AT_S]
        if placed and self.point is None:
            raise InputError(
                f"point missing for {', '.join(placed)}; give 'point: S' if the place "
                "that is measured is the robot's feature_point, else move that there"
            )
        return self

    def in_base(self, v_S: Vectors) -> Vectors:
        """`v_B = R_BS v_S`."""
        # Turning by nothing would let a NaN of one axis into the others.
        if self.rotation is None:
            return v_S
        return rotate(quaternion_matrix(self._x_BS), v_S)

    def of_base(self, x_WS: Quaternions) -> Quaternions:
        """`R_WB = R_WS R_BS^T`."""
        return x_WS if self.rotation is None else product(x_WS, conjugate(self._x_BS))

    @property
    def _x_BS(self) -> Quaternions:
        return np.array([self.rotation], dtype=np.float64)
