"""Reads text and YAML, and says in one line why that is not possible."""

from pathlib import Path
from typing import Any

import yaml

from orbident.errors import InputError
from orbident.robot.names import first_duplicate

# PyYAML can be built without libyaml.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, line ends untouched.

    Raises:
        InputError: the file is missing, a directory, unreadable or not UTF-8.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: byte {error.start} is not UTF-8 text; give a text file in UTF-8"
        ) from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a directory; give a file") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None


def read_yaml_mapping(text: str, place: str) -> dict[str, Any]:
    """A YAML document whose top level has keys.

    Args:
        text: the document.
        place: the file's name, for messages.

    Raises:
        InputError: the text is no YAML, has a key twice, or is no mapping.
    """
    try:
        _refuse_repeated_keys(yaml.compose(text, Loader=_Loader))
        document = yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        raise InputError(_yaml_problem(error, place)) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{place}: no valid YAML: {reason}") from None
    if isinstance(document, dict):
        return document
    found = "an empty file" if document is None else f"a {type(document).__name__}"
    raise InputError(
        f"{place}: found {found}; give keys and values, "
        "first 'schema: orbident/robot/1'"
    )


def _yaml_problem(error: yaml.MarkedYAMLError, place: str) -> str:
    mark = error.problem_mark
    where = place if mark is None else f"{place}:{mark.line + 1}"
    return f"{where}: no valid YAML: {error.problem or error.context}"


def _refuse_repeated_keys(root: yaml.Node | None) -> None:
    """YAML forbids a key twice in a mapping; PyYAML lets the last one win."""
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
        twice = first_duplicate(key.value for key in keys)
        if twice is not None:
            second = [key for key in keys if key.value == twice][1]
            problem = f"the key {twice!r} is given twice; keep one"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=second.start_mark)
        waiting += [value for _, value in node.value]
