"""How our YAML files are read, and what their schemas are made of."""

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Annotated, Any, ClassVar, TypeVar

import yaml
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
from orbident.files.names import first_duplicate, quoted, suggestion

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


def validated(
    model: type[Model],
    document: dict[Any, Any],
    place: str,
    text: str = "",
    within: tuple[int | str, ...] = (),
) -> Model:
    """The document as an instance of a schema.

    The schema is a class with typed fields; messages begin with the place, and tell the
    line of the YAML text that was read. The document is all of it, or the part within
    these keys.

    Raises:
        InputError: the first thing that is wrong, and how many more there are.
    """
    try:
        return adapter(model).validate_python(document)
    except ValidationError as error:
        raise InputError(_one_line(error, place, text, within)) from None


def _one_line(
    error: ValidationError, place: str, text: str, within: tuple[int | str, ...]
) -> str:
    # A file of another kind has many faults; the schema is the one that says so.
    faults = error.errors(include_url=False)
    first, *others = sorted(faults, key=lambda fault: fault["loc"] != ("schema",))
    cause = first.get("ctx", {}).get("error")
    unknown = (cause.key,) if isinstance(cause, _UnknownKeyError) else ()
    location = (*within, *first["loc"])
    where = ": ".join(
        filter(None, (place + line_of(text, (*location, *unknown)), _path(location)))
    )
    more = f" (and {len(others)} more)" if others else ""
    return " ".join(f"{where}: {_problem(first)}{more}".split())


def line_of(text: str, location: tuple[object, ...]) -> str:
    """`:12`, the line of the last key of a location that is there; else nothing."""
    node, line = yaml.compose(text, Loader=_StrictLoader), ""
    for key in map(str, location):
        entries = {}
        if isinstance(node, yaml.MappingNode):
            entries = {
                k.value: (k, x) for k, x in node.value if isinstance(k.value, str)
            }
        elif isinstance(node, yaml.SequenceNode):
            entries = {str(k): (x, x) for k, x in enumerate(node.value)}
        if key in entries:
            at, node = entries[key]
            line = f":{at.start_mark.line + 1}"
    return line


def _path(location: tuple[int | str, ...]) -> str:
    """`("wheels", 0, "axis")` as `wheels[0].axis`."""
    keys = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in location)
    return "".join(keys).removeprefix(".").removesuffix(".[key]")


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


class _UnknownKeyError(InputError):
    """A key of a mapping that has none of this name."""

    key: object = None


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
            error = _UnknownKeyError(f"unknown key {quoted(key)}; {known}")
            error.key = key
            raise error
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


# PyYAML can be built without libyaml.
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_KINDS = {list: "a list", str: "text"}

DEEPEST = 50
"""Levels of lists and mappings. Our files have up to 6; libyaml, which goes down by
recursion, overflows its stack beyond some 10,000."""

# As in YAML 1.2. That of YAML 1.1, PyYAML's, has "on" and "no" for truth values, 1:30
# for 90 and 010 for 8; here they are text, as are dates.
_PLAIN = {
    "bool": (r"true|True|TRUE|false|False|FALSE", "tTfF"),
    "int": (r"[-+]?(0|[1-9][0-9]*)", "-+0123456789"),
    "float": (
        r"[-+]?([0-9]+\.[0-9]*|\.[0-9]+)([eE][-+][0-9]+)?"
        r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        "-+0123456789.",
    ),
}


def read_yaml_mapping(text: str, place: str, schema: str) -> dict[Any, Any]:
    """A YAML document whose top level has keys.

    Messages name the place, and the schema of such a file.

    Raises:
        InputError: the text is no YAML, has a key twice, or is no mapping.
    """
    try:
        _check_depth(text)
        document = yaml.load(text, Loader=_StrictLoader)
    except _Refused as error:
        raise InputError(f"{_where(error, place)}: {error.problem}") from None
    except yaml.MarkedYAMLError as error:
        problem = error.problem or error.context
        raise InputError(
            f"{_where(error, place)}: no valid YAML: {problem}; correct it"
        ) from None
    except (yaml.YAMLError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{place}: no valid YAML: {reason}; correct it") from None
    if isinstance(document, dict):
        return document
    kind = _KINDS.get(type(document), "a single value")
    found = "an empty file" if document is None else kind
    raise InputError(
        f"{place}: found {found}; give keys and values, first 'schema: {schema}'"
    )


def _where(error: yaml.MarkedYAMLError, place: str) -> str:
    mark = error.problem_mark
    return place if mark is None else f"{place}:{mark.line + 1}:{mark.column + 1}"


class _Refused(yaml.MarkedYAMLError):
    """What YAML allows, or PyYAML does, and our files do not."""


class _StrictLoader(_Loader):
    """Values as in YAML 1.2, and no key twice, where PyYAML lets the last one win."""

    def get_single_node(self) -> yaml.Node | None:
        root = super().get_single_node()
        _refuse_repeated_keys(root)
        return root

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except (KeyError, AttributeError, IndexError):
            # PyYAML's constructors take it for granted that a value fits its tag.
            kind = node.tag.removeprefix("tag:yaml.org,2002:")
            raise _Refused(
                problem=f"found {quoted(node.value)} tagged '!!{kind}', which it is "
                "not; leave out the tag",
                problem_mark=node.start_mark,
            ) from None


_StrictLoader.yaml_implicit_resolvers = {
    first: [
        (tag, pattern)
        for tag, pattern in resolvers
        if tag.removeprefix("tag:yaml.org,2002:") not in {*_PLAIN, "timestamp"}
    ]
    for first, resolvers in _Loader.yaml_implicit_resolvers.items()
}
for _kind, (_pattern, _first) in _PLAIN.items():
    _StrictLoader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_kind}", re.compile(f"(?:{_pattern})$"), list(_first)
    )


def _check_depth(text: str) -> None:
    """Refuse deep nesting; events come one by one, without recursion."""
    depth = 0
    try:
        for event in yaml.parse(text, Loader=_Loader):
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST:
                raise _too_deep(event.start_mark)
    except yaml.MarkedYAMLError as error:
        # LibYAML looks ahead, and has a limit of its own since PyYAML 6.0.4.
        if "nesting depth" in str(error.problem):
            raise _too_deep(error.problem_mark) from None
        raise


def _too_deep(mark: Any) -> _Refused:
    return _Refused(
        problem=f"lists and mappings are nested more than {DEEPEST} deep; "
        "give a file of the kind that is asked for",
        problem_mark=mark,
    )


def _refuse_repeated_keys(root: yaml.Node | None) -> None:
    waiting, visited = [root], set()
    while waiting:
        node = waiting.pop()
        if not isinstance(node, yaml.CollectionNode) or id(node) in visited:
            continue
        # An alias is the same node again, and may contain itself.
        visited.add(id(node))
        if isinstance(node, yaml.SequenceNode):
            waiting += node.value
            continue
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        # The tag tells 1 from "1".
        twice = first_duplicate((key.tag, key.value) for key in keys)
        if twice is not None:
            second = [key for key in keys if (key.tag, key.value) == twice][1]
            raise _Refused(
                problem=f"the key {quoted(second.value)} is given twice; keep one",
                problem_mark=second.start_mark,
            )
        waiting += [value for _, value in node.value]
