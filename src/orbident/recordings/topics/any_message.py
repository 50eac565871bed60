"""A message of any type whose definition is in the bag: its numbers, and its entry."""

from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from itertools import islice
from math import nan
from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.recordings.topics.entry import LONGEST, Extraction, header_stamp
from orbident.recordings.topics.fields import Fields

_NUMBERS = 300
"""So many numbers of a message are shown; an image has a million."""


def numbers_of(message: Any) -> dict[str, float]:
    """The first numbers of a message but its header's, by their paths."""
    return dict(islice(_numbers("", message, ()), _NUMBERS))


def _numbers(path: str, value: Any, names: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, int | float | np.number):
        yield path, float(value)
    for name, part in _parts(value, names).items():
        if name != "header":
            inner = f"{path}.{name}" if path else name
            yield from _numbers(inner, part, getattr(value, "name", ()))


def _parts(value: Any, names: Any) -> Mapping[str, Any]:
    """The fields of a message, or the elements of an array by name, else by number.

    The field `name` beside an array, as `sensor_msgs/JointState` has it, is `names`;
    messages in an array may have a `name` each.
    """
    if is_dataclass(value):
        return vars(value)
    if not isinstance(value, list | np.ndarray):
        return {}
    keys: Any = names if isinstance(names, list) else ()
    if any(map(is_dataclass, value)):
        keys = [getattr(each, "name", None) for each in value]
    if len({*keys}) != len(value) or not all(isinstance(key, str) for key in keys):
        keys = map(str, range(len(value)))
    return dict(zip(keys, value, strict=True))


def _steps(message: Any, path: str) -> Iterator[tuple[str, Mapping[str, Any], Any]]:
    """Each key of a path, the parts among which it is, by number too, and of what."""
    found, names = message, ()
    for key in path.split("."):
        parts = _parts(found, names)
        parts = {str(k): each for k, each in enumerate(parts.values())} | {**parts}
        yield key, parts, found
        found, names = parts.get(key), getattr(found, "name", ())


class Message(Fields):
    """A table of one row; a field is a path in the message, such as `pose.position.x`.

    Elements of an array have a number, from 0, or their name: `data.3`, `position.arm`.
    The time is that of the fields in `stamp`, else of the header, else of recording.
    """

    time: Literal["header", "receive"] = "header"

    @model_validator(mode="before")
    @classmethod
    def _of_std_msgs(cls, document: Any) -> Any:
        """They have no header, and the one number of a Float64 need not be named."""
        if not str(document.get("type")).startswith("std_msgs/"):
            return document
        if document.get("time") == "header":
            raise InputError("time: std_msgs have no header; leave this key out")
        take, document = document.get("take"), {"time": "receive", **document}
        if not isinstance(take, dict) or "fields" in document:
            return document
        if len(take) != 1:
            raise InputError(
                f"take names {len(take)} columns; a Float64 feeds one: "
                "{wheel.<name>.speed: rad/s}"
            )
        return {**document, "fields": dict.fromkeys(take, "data")}

    @model_validator(mode="after")
    def _one_time(self) -> "Message":
        if self.stamp and "time" in self.model_fields_set:
            raise InputError("time: the time is in 'stamp'; leave this key out")
        return self

    @property
    def sender_time(self) -> str:
        """Fields may be the time."""
        return "stamp" if self.stamp else "header"

    def samples(self, message: Any) -> Iterator[Extraction]:
        """One, in the order of the slots."""
        values = [
            (s.factor * self._number(message, s.field) if s.field else 0.0) + s.offset
            for s in self.slots
        ]
        yield self._sent(message), values

    def lacked(self, message: Any, column: str) -> str:
        """The element that an array never has, and those that it has."""
        for target in self.targets:
            slots = self._slots_of(target) if column in target.columns else ()
            for path in (slot.field for slot in slots if slot.field):
                for key, parts, _ in _steps(message, path):
                    if key not in parts:
                        known = suggestion(key, parts, "elements")
                        return f"'{path}': there is no '{key}'; {known}"
        return ""

    def _sent(self, message: Any) -> int:
        if not self.stamp:
            return header_stamp(getattr(message, "header", None))
        units = zip(self.stamp, self.counts, strict=True)
        ns = sum(self._number(message, field) * count for field, count in units)
        return round(ns) if 0 < ns < LONGEST else 0

    def _number(self, message: Any, path: str) -> int | float:
        """A number of the message; NaN where an array has no such element.

        Raises:
            InputError: there is no such field, or it is no number.
        """
        found = message
        for key, parts, within in _steps(message, path):
            if key not in parts and isinstance(within, list | np.ndarray):
                return nan
            found = parts.get(key)
        if isinstance(found, np.number):
            found = found.item()
        if not isinstance(found, int | float):
            known = suggestion(path, numbers_of(message), "fields")
            raise InputError(
                f"topic '{self.topic}': '{path}' is no number of its messages; {known}"
            )
        return found
