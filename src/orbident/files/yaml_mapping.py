"""YAML whose top level has keys, none of them twice."""

import re
from typing import Any

import yaml

from orbident.errors import InputError
from orbident.files.names import first_duplicate, quoted

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

    Args:
        text: the document.
        place: the file's name, for messages.
        schema: what the key "schema" has in such a file, for messages.

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
