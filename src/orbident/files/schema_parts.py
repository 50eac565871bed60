"""What every file's schema is made of: sections with fixed keys, and numbers."""

import math
from contextlib import suppress
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, model_validator

from orbident.errors import InputError
from orbident.files.names import suggestion


def finite_number(value: object) -> float:
    """The value as a number, also where it is text: `1e-4`, which YAML wants as 1.0e-4.

    Raises:
        InputError: not a finite number. A truth value is none either: YAML reads "yes"
            as one.
    """
    if isinstance(value, int | float | str) and not isinstance(value, bool):
        with suppress(ValueError, OverflowError):
            if math.isfinite(number := float(value)):
                return number
    raise InputError("give a finite number")


def finite_vector(value: object, length: int) -> tuple[float, ...]:
    """The value as a vector of finite numbers.

    Raises:
        InputError: not a list of that length, or not of finite numbers.
    """
    if not isinstance(value, list | tuple) or len(value) != length:
        raise InputError(f"give a {length}-vector")
    try:
        return tuple(finite_number(each) for each in value)
    except InputError:
        raise InputError(f"give a {length}-vector of finite numbers") from None


def _positive(value: object) -> float:
    number = finite_number(value)
    if number <= 0:
        raise InputError("give a number above zero")
    return number


Number = Annotated[float, BeforeValidator(finite_number)]
Positive = Annotated[float, BeforeValidator(_positive)]
Vector3 = Annotated[
    tuple[float, float, float], BeforeValidator(lambda value: finite_vector(value, 3))
]
Vector4 = Annotated[
    tuple[float, float, float, float],
    BeforeValidator(lambda value: finite_vector(value, 4)),
]


class Section(BaseModel):
    """A mapping with fixed keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        """Names an unknown key and the known ones, which pydantic does not."""
        if not isinstance(data, dict):
            raise InputError("give keys and values: " + ", ".join(cls._keys()))
        for key in data:
            if key not in cls._keys():
                known = suggestion(str(key), cls._keys(), "keys")
                raise InputError(f"unknown key {key!r}; {known}")
        return data

    @classmethod
    def _keys(cls) -> tuple[str, ...]:
        return tuple(field.alias or name for name, field in cls.model_fields.items())
