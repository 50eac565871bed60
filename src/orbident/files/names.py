"""How a message helps with a name that is not known, or given twice."""

import struct
import zipfile
import zlib
from collections.abc import Collection, Hashable, Iterable
from difflib import get_close_matches
from itertools import accumulate
from typing import TypeVar

from orbident.errors import QUOTED, InputError

Name = TypeVar("Name", bound=Hashable)


LISTED = 400
"""Characters of a list of names: a line has room for two of them, and for words."""


def quoted(value: object) -> str:
    """What was found, as Python writes it, on one line and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= QUOTED else text[: QUOTED - 3] + "..."


_IN_WORDS = (
    ((zlib.error, zipfile.BadZipFile), "its compressed data are damaged"),
    ((struct.error, EOFError), "it ends too early"),
    # What Python says of these, "'x'" or "NoneType has no ...", is of the program.
    (
        (LookupError, TypeError, AttributeError, AssertionError),
        "its parts do not fit together",
    ),
)
"""Errors whose own words are no help to who reads a message."""


def one_line(error: Exception) -> str:
    """An error of a library, short enough for the end of a message."""
    for kinds, words in _IN_WORDS:
        if isinstance(error, kinds):
            return words
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 160 else text[:157] + "..."


def counted(number: int, one: str, several: str = "") -> str:
    """`1 wheel`, `2 wheels`: a number of things; the plural where it is no mere s."""
    return f"{number} {one if number == 1 else several or f'{one}s'}"


def listed(names: Iterable[str]) -> str:
    """`'x', 'y' and 7 more`: names, as many as one can read at a glance."""
    return joined(map(quoted, names))


def joined(texts: Iterable[str]) -> str:
    """`x, y and 7 more`: the first texts, as many as one can read at a glance."""
    texts = tuple(texts)
    ends = accumulate(len(text) + len(", ") for text in texts)
    shown = sum(end <= LISTED for end in ends)
    more = f" and {len(texts) - shown} more" if shown < len(texts) else ""
    return (", ".join(texts[:shown]) or "none") + more


def closest(name: str, known: Iterable[str]) -> str | None:
    """The known name that may have been meant, if one is close."""
    return next(iter(get_close_matches(name, tuple(known), n=1)), None)


def suggestion(name: str, known: Iterable[str], what: str) -> str:
    """`did you mean 'x'? known joints: 'x', 'y'`, for the end of a message.

    `what` is a plural.
    """
    known = tuple(known)
    close = closest(name, known)
    hint = f"did you mean {quoted(close)}? " if close else ""
    return f"{hint}known {what}: {listed(known)}"


def refuse_unknown(name: str, known: Collection[str], fault: str, what: str) -> None:
    """Refuse a name that is not known, in words; `what` is a plural, such as "joints".

    Raises:
        InputError: it is not: the fault, and a suggestion.
    """
    if name not in known:
        raise InputError(f"{fault}; {suggestion(name, known, what)}")


def first_duplicate(names: Iterable[Name]) -> Name | None:
    """The first name that comes a second time, if any does."""
    seen = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None
