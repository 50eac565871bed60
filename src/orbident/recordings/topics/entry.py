"""What every entry of a topic map has: a topic, its clock, and what is taken."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import (
    MappingSchema,
    Name,
    WrongValueError,
    finite_number,
)

LONGEST = 2**62
"""ns, 146 years; so far the sum of a time's fields goes, and its offset."""


Extraction = tuple[int, Sequence[float]]
"""What an entry takes from one message: the sender's stamp, ns, 0 where there is none,
and values as they are in the message, NaN where it has none."""


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
    def taken(self) -> dict[str, Any]:
        """The units by the keys that are given."""
        return {key: unit for key, unit in self if unit is not None}


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
