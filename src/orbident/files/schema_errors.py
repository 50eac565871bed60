"""A pydantic error as one clear line: place, what was found, what to do."""

from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.files.schema_parts import WrongValueError, adapter

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
    return f"found {_found(detail['input'])}; {remedy}"


def _found(value: object) -> str:
    return "nothing" if value is None else quoted(value)
