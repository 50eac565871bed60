"""std_msgs/Float64: one number a message, without a stamp."""

from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from pydantic import model_validator

from orbident.errors import InputError
from orbident.recordings.bags.entry import AT_S, TURNED, Entry, Sample
from orbident.recordings.bags.units import Unit, unit_of
from orbident.recordings.columns import is_known, joint_of, wheel_of

_VECTOR_DIMENSIONS = {
    "gyro": "angular rate",
    "accelerometer": "acceleration",
    "position": "length",
    "velocity": "velocity",
    "force": "force",
    "torque": "torque",
}


class Scalar(Entry):
    """Its time is when it was recorded: there is no other."""

    take: Mapping[str, Any]
    time: Literal["header", "receive"] = "receive"
    frame: Literal["base"] | None = None
    point: Literal["S"] | None = None

    @model_validator(mode="after")
    def _one_column(self) -> "Scalar":
        if len(self.take) != 1:
            raise InputError(
                f"take names {len(self.take)} columns; a Float64 feeds one: "
                "{wheel.<name>.speed: rad/s}"
            )
        if self.time == "header":
            raise InputError("time: a Float64 has no header; leave this key out")
        head = self._column.split(".")[0]
        try:
            # Raises where the unit is none of the column's.
            _ = self._unit
        except InputError as error:
            found = self.take[self._column]
            raise InputError(
                f"take: {self._column}: found {found!r}; {error}"
            ) from None
        if head in TURNED and self.frame is None:
            raise InputError(
                "frame missing; give 'frame: base' if the axis is the base's"
            )
        if head in AT_S and self.point is None:
            raise InputError(
                "point missing; give 'point: S' if that is the place measured"
            )
        return self

    @property
    def _column(self) -> str:
        return next(iter(self.take))

    @property
    def _unit(self) -> Unit:
        return unit_of(*_dimensions(self._column))(self.take[self._column])

    @property
    def columns(self) -> tuple[str, ...]:
        """The one column."""
        return (self._column,)

    def samples(self, message: Any) -> Iterator[Sample]:
        """The number."""
        yield Sample(None, (message.data,))

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """In SI."""
        return raw * self._unit.si


def _dimensions(column: str) -> tuple[str, ...]:
    head, last = column.split(".")[0], column.rsplit(".", 1)[-1]
    if joint_of(column):
        both = last == "position"
        return ("angle", "length") if both else ("angular rate", "velocity")
    if wheel_of(column):
        return ("angle",) if last == "position" else ("angular rate",)
    if not is_known(column) or head not in _VECTOR_DIMENSIONS:
        raise InputError(
            "give a column that one number can fill, such as wheel.<name>.speed, "
            "joint.<name>.position or gyro.z"
        )
    return (_VECTOR_DIMENSIONS[head],)
