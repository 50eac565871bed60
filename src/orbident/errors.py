"""The one exception that means: the input is wrong, and here is what to do."""

import re

QUOTED = 80
"""Characters of a name in a message: a line is to be read at a glance."""

LONGEST_WORD = 255
"""Characters: no system has a longer file name, and paths are not to be cut."""

_QUOTED = re.compile(r"(?<!\w)'([^']*)'(?!\w)")
_LONG_WORD = re.compile(rf"([^\s/]{{{QUOTED - 3}}})[^\s/]{{{LONGEST_WORD - QUOTED},}}")


def readable(message: str) -> str:
    """The message with names cut that nobody could read."""
    return _LONG_WORD.sub(r"\1...", _QUOTED.sub(_cut, message))


def _cut(quoted: re.Match[str]) -> str:
    name = quoted[1]
    return quoted[0] if len(name) <= QUOTED else f"'{name[: QUOTED - 3]}...'"


class InputError(ValueError):
    """What a user gave cannot be used.

    The message is one line: the place, what was found, and what to do. The
    command prints it on standard error and exits with status 2.
    """

    def __init__(self, message: object = "") -> None:
        """Keep the message, its names cut where they are very long."""
        super().__init__(readable(str(message)))
