"""How a message helps with a name that is not known."""

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(name: str, known: Iterable[str], what: str) -> str:
    """`did you mean 'x'? known joints: 'x', 'y'`, for the end of a message.

    Args:
        name: what was found.
        known: what there is.
        what: a plural: "joints", "keys".
    """
    known = tuple(known)
    listed = ", ".join(repr(each) for each in known) or "none"
    close = get_close_matches(name, known, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"{hint}known {what}: {listed}"


def first_duplicate(names: Iterable[str]) -> str | None:
    """The first name that comes a second time, if any does."""
    seen = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None
