"""YAML whose top level has keys, none of them twice."""

from typing import Any

import yaml

from orbident.errors import InputError
from orbident.files.names import first_duplicate

# PyYAML can be built without libyaml.
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_KINDS = {list: "a list", str: "text"}


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
        document = yaml.load(text, Loader=_UniqueKeyLoader)
    except _RepeatedKey as error:
        raise InputError(f"{_where(error, place)}: {error.problem}") from None
    except yaml.MarkedYAMLError as error:
        problem = error.problem or error.context
        raise InputError(
            f"{_where(error, place)}: no valid YAML: {problem}; correct it"
        ) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
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


class _RepeatedKey(yaml.MarkedYAMLError):
    pass


class _UniqueKeyLoader(_Loader):
    """YAML forbids a key twice in a mapping; PyYAML lets the last one win."""

    def get_single_node(self) -> yaml.Node | None:
        root = super().get_single_node()
        _refuse_repeated_keys(root)
        return root


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
            raise _RepeatedKey(
                problem=f"the key {second.value!r} is given twice; keep one",
                problem_mark=second.start_mark,
            )
        waiting += [value for _, value in node.value]
