"""Types of what a file of JSON holds: what checks it, reads it and writes it.

Python has NaN where JSON has null, arrays where it has lists, and tuples with names
where it has keys and values. The types here stand at the fields of classes: a class is
all that pydantic needs to write its objects and to make them of a document again.
"""

from collections.abc import Callable
from functools import partial
from typing import (
    Annotated,
    Any,
    NamedTuple,
    NotRequired,
    TypeVar,
    get_args,
    get_type_hints,
)

import numpy as np
from jaxtyping import Float
from pydantic import (
    BeforeValidator,
    Field,
    GetCoreSchemaHandler,
    InstanceOf,
    PlainSerializer,
)
from pydantic_core import CoreSchema, core_schema
from typing_extensions import TypedDict

from orbident.files.schema_parts import WrongValueError, adapter

LARGEST_KNOWN = 1e60
"""SI. Deviations of what is hardly determined are large; the fourth power of this is
still a float64."""

MOST_COUNTED = 10**12
"""Samples."""

Rows = list[list[float]]
T = TypeVar("T")


class JsonPart:
    """What a file of JSON holds, with its fields."""

    def to_json(self) -> dict[str, Any]:
        """Keys and values as in the file: null for NaN."""
        return adapter(type(self)).dump_python(self, mode="json", by_alias=True)


def nulled(numbers: Float[np.ndarray, "..."] | float | None) -> Any:
    """Numbers as JSON has them: null for what is not finite."""
    if isinstance(numbers, np.ndarray):
        return [nulled(number) for number in numbers]
    return None if numbers is None or not np.isfinite(numbers) else float(numbers)


def _or_none(value: object) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WrongValueError("a number is expected, or null")
    if not abs(value) <= LARGEST_KNOWN:
        raise WrongValueError(
            f"a number of at most {LARGEST_KNOWN:g}, or null, is expected"
        )
    return float(value)


def _or_nan(value: object) -> float:
    number = _or_none(value)
    return np.nan if number is None else number


def _std(value: object) -> float:
    std = _or_nan(value)
    if std < 0:
        raise WrongValueError("a deviation is not negative")
    return std


def _finite(value: object) -> float:
    number = _or_none(value)
    if number is None:
        raise WrongValueError("a number is expected")
    return number


NumberOrNone = Annotated[
    float | None, BeforeValidator(_or_none), PlainSerializer(nulled)
]
NullableNumber = Annotated[float, BeforeValidator(_or_nan), PlainSerializer(nulled)]
NullableStd = Annotated[float, BeforeValidator(_std), PlainSerializer(nulled)]
FiniteNumber = Annotated[float, BeforeValidator(_finite)]
Count = Annotated[int, Field(strict=True, ge=0, le=MOST_COUNTED)]


class InFile(NamedTuple):
    """How a file holds what Python has in another form."""

    form: Callable[[Any], Any]
    """The type in the file, of that in Python."""
    read: Callable[[Any, Any], Any]
    """What Python has, of its type and of what the file holds."""
    write: Callable[[Any], Any]
    """What the file holds."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """As pydantic asks for it."""
        form = handler.generate_schema(self.form(source))
        return core_schema.no_info_after_validator_function(
            partial(self.read, source),
            form,
            serialization=core_schema.plain_serializer_function_ser_schema(
                self.write, return_schema=form
            ),
        )


def held_as(
    form: Any,
    read: Callable[[Any], Any] = np.array,
    write: Callable[[Any], Any] = np.ndarray.tolist,
) -> InFile:
    """How a file holds something always as the same type, by default an array."""
    return InFile(lambda _: form, lambda _, value: read(value), write)


def _table(rows: Rows) -> Float[np.ndarray, "rows columns"]:
    columns = len(rows[0]) if rows else 0
    if any(len(row) != columns for row in rows):
        raise WrongValueError("rows of one length are expected")
    return np.array(rows).reshape(len(rows), columns)


def _symmetric(lower: Rows) -> Float[np.ndarray, "n n"]:
    if any(len(row) != k + 1 for k, row in enumerate(lower)):
        raise WrongValueError("rows that end at the diagonal are expected")
    matrix = np.zeros((len(lower), len(lower)))
    for k, row in enumerate(lower):
        matrix[k, : k + 1] = matrix[: k + 1, k] = row
    return matrix


def _lower(matrix: Float[np.ndarray, "n n"]) -> Rows:
    return [row[: k + 1].tolist() for k, row in enumerate(matrix)]


_ROWS = list[list[NullableNumber]]

NullableVector = Annotated[Float[np.ndarray, " n"], held_as(list[NullableNumber])]
NullableStds = Annotated[Float[np.ndarray, " n"], held_as(list[NullableStd])]
NullableTable = Annotated[Float[np.ndarray, "rows columns"], held_as(_ROWS, _table)]
NullableSquare = Annotated[Float[np.ndarray, "n n"], held_as(_ROWS, _table)]
Symmetric = Annotated[
    Float[np.ndarray, "size size"], held_as(_ROWS, _symmetric, _lower)
]
"""A file has its rows as far as the diagonal."""


def _keys(source: Any) -> Any:
    hints = {
        name: NotRequired[hint] if name in source._field_defaults else hint
        for name, hint in get_type_hints(source, include_extras=True).items()
    }
    # A type checker knows the keys of no dictionary that is made at run time.
    made: Any = TypedDict
    return made(source.__name__, hints)


Keyed = Annotated[
    T,
    InFile(_keys, lambda kind, values: kind(**values), lambda values: values._asdict()),
]
"""`Keyed[X]` is a named tuple `X` that a file holds as keys and values."""

Computed = Annotated[
    Callable[[], T],
    InFile(
        lambda kind: get_args(kind)[1],
        lambda _, value: as_computed(value),
        lambda function: function(),
    ),
]
"""`Computed[X]` is a function without arguments, of which a file holds the `X`."""

Unwritten = Annotated[InstanceOf[T] | None, Field(exclude=True)]
"""`Unwritten[X]` is an `X`, or None, that no file holds."""


def as_computed(value: T) -> Callable[[], T]:
    """A function that gives this value, and that can be sent to another process."""
    return partial(_same, value)


def _same(value: T) -> T:
    return value
