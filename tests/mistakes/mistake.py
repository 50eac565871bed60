"""One mistake as data: how it is made, and what a message must say of it."""

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from recordings import ROBOTS, SPACE, TABLE
from spoiled import Spoil

IN_SPACE, ON_TABLE = (SPACE,), (TABLE,)


class Mistake(NamedTuple):
    """One thing that is wrong."""

    name: str
    spoil: Spoil
    cause: str
    """Words that a message which names the true cause has all of; of `a|b` one, and
    `a*` is any word that begins so."""
    robots: tuple[str, ...] = ROBOTS
    unobservable: tuple[str, ...] = ()
    """Robots on which nobody can see it: see `visibility.py`."""
    tolerance: Mapping[str, Any] | None = None
    """What in a robot file's `tolerances:` covers it: standard deviations, SI."""
    group: str = ""

    def is_named(self, message: str) -> bool:
        """Whether a message names the true cause."""
        return all(
            re.search(rf"\b({_pattern(words)})\b", message, re.IGNORECASE)
            for words in self.cause.split()
        )


def _pattern(words: str) -> str:
    """Whole words, one or several of a thing; `*` is any end."""
    return "|".join(word.replace("*", r"\w*") + "s?" for word in words.split("|"))


def twice(
    name: str, make: Callable[[float], Spoil], *sizes: float, cause: str, **more: Any
) -> tuple[Mistake, ...]:
    """One kind in several sizes; `name` has the place of the size."""
    return tuple(
        Mistake(name.format(size), make(size), cause, **more) for size in sizes
    )


Groups = Mapping[str, tuple[Mistake, ...]]
