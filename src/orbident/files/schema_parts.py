"""What every file's schema is made of: sections with fixed keys, and numbers.

What pydantic says of a document that does not fit is made one clear line.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.files.names import quoted, suggestion

Model = TypeVar("Model")

_REMEDIES = {
    "tuple_type": "give a list",
    "list_type": "give a list",
    "dict_type": "give names and their entries",
    "string_type": "give text, in quotes if it looks like a number",
    "bool_type": "give true or false",
    "bool_parsing": "give true or false",
    "string_too_short": "give a name",
}


def validated(model: type[Model], document: dict[Any, Any], place: str) -> Model:
    """The document as an instance of a schema.

    Args:
        model: the schema, a class with typed fields.
        document: keys and values, as read.
        place: the file's name, for messages.

    Raises:
        InputError: the first thing that is wrong, and how many more there are.
    """
    try:
        return adapter(model).validate_python(document)
    except ValidationError as error:
        raise InputError(_one_line(error, place)) from None


def _one_line(error: ValidationError, place: str) -> str:
    # A file of another kind has many faults; the schema is the one that says so.
    faults = error.errors(include_url=False)
    first, *others = sorted(faults, key=lambda fault: fault["loc"] != ("schema",))
    where = ": ".join(filter(None, (place, _path(first["loc"]))))
    more = f" (and {len(others)} more)" if others else ""
    return " ".join(f"{where}: {_problem(first)}{more}".split())


def _path(location: tuple[int | str, ...]) -> str:
    """`("wheels", 0, "axis")` as `wheels[0].axis`."""
    path = ""
    for key in location:
        path += f"[{key}]" if isinstance(key, int) else f".{key}"
    return path.removeprefix(".").removesuffix(".[key]")


def _problem(detail: ErrorDetails) -> str:
    if detail["type"] == "missing":
        return "this key is missing; add it"
    cause = detail.get("ctx", {}).get("error")
    # What a section says of itself names the key that is wrong.
    own = isinstance(detail["input"], dict) and not isinstance(cause, WrongValueError)
    if own and isinstance(cause, InputError):
        return str(cause)
    expected = detail["msg"].removeprefix("Input should be ")
    remedy = cause or _REMEDIES.get(detail["type"], f"give {expected}")
    found = "nothing" if detail["input"] is None else quoted(detail["input"])
    return f"found {found}; {remedy}"


@cache
def adapter(model: Any) -> Any:
    """What checks, reads and writes objects of a class with typed fields."""
    return TypeAdapter(model)


class WrongValueError(InputError):
    """A value that is wrong by itself, whatever stands beside it: it is to be shown."""


def finite_number(value: object) -> float:
    """The value as a number, also where it is text: `1e-4`, which YAML takes for text.

    Raises:
        WrongValueError: no number, or larger than any of a spacecraft. A truth value
            is no number either.
    """
    number = math.nan
    if isinstance(value, int | float | str) and not isinstance(value, bool):
        with suppress(ValueError, OverflowError):
            number = float(value)
    if not math.isfinite(number):
        raise WrongValueError("give a finite number")
    if abs(number) > LARGEST:
        raise WrongValueError(f"give a number of at most {LARGEST:g}, in SI units")
    return number


def finite_vector(value: object, length: int) -> tuple[float, ...]:
    """The value as a vector of finite numbers.

    Raises:
        WrongValueError: not a list of that length, or not of finite numbers.
    """
    if not isinstance(value, list | tuple) or len(value) != length:
        raise WrongValueError(f"give a {length}-vector")
    try:
        return tuple(finite_number(each) for each in value)
    except WrongValueError as error:
        wanted = str(error).removeprefix("give a ").replace("number", "numbers", 1)
        raise WrongValueError(f"give a {length}-vector of {wanted}") from None


def positive_number(value: object) -> float:
    """The value as a number above zero.

    Raises:
        WrongValueError: none, or smaller or larger than any of a spacecraft.
    """
    number = finite_number(value)
    if number <= 0:
        raise WrongValueError("give a number above zero")
    if number < SMALLEST:
        raise WrongValueError(f"give a number of at least {SMALLEST:g}, in SI units")
    return number


Number = Annotated[float, BeforeValidator(finite_number)]
Positive = Annotated[float, BeforeValidator(positive_number)]
Vector3 = Annotated[
    tuple[float, float, float], BeforeValidator(lambda value: finite_vector(value, 3))
]
Vector4 = Annotated[
    tuple[float, float, float, float],
    BeforeValidator(lambda value: finite_vector(value, 4)),
]


def nonzero_vector(value: object) -> tuple[float, ...]:
    """The value as a vector of three finite numbers that are not all zero.

    Raises:
        WrongValueError: it is none.
    """
    vector = finite_vector(value, 3)
    if max(map(abs, vector)) < SMALLEST:
        raise WrongValueError("give a nonzero 3-vector")
    return vector


Direction = Annotated[tuple[float, float, float], BeforeValidator(nonzero_vector)]
Name = Annotated[str, Field(min_length=1)]


def with_known_keys(data: Any, keys: Sequence[str]) -> Any:
    """A mapping as it is given, if it has no other keys than these.

    Raises:
        InputError: it names an unknown key and the known ones, which pydantic does not.
    """
    if not isinstance(data, dict):
        raise WrongValueError("give keys and values: " + ", ".join(keys))
    for key in data:
        if key not in keys:
            known = suggestion(str(key), keys, "keys")
            raise InputError(f"unknown key {quoted(key)}; {known}")
    return data


def keys_of(kind: type) -> BeforeValidator:
    """Lets pydantic make a dataclass or a named tuple of a mapping with its fields."""
    keys = tuple(kind.__annotations__)
    return BeforeValidator(lambda data: with_known_keys(data, keys))


class MappingSchema(BaseModel):
    """A mapping with fixed keys."""

    model_config: ClassVar[ConfigDict] = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        return with_known_keys(data, cls._keys())

    @classmethod
    def _keys(cls) -> tuple[str, ...]:
        return tuple(field.alias or name for name, field in cls.model_fields.items())
