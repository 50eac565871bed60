"""One mistake as data: how it is made, and what a message must say of it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from recordings import ROBOTS, SPACE, TABLE
from spoiled import Spoil

IN_SPACE, ON_TABLE = (SPACE,), (TABLE,)


class Mistake(NamedTuple):
    """One thing that is wrong."""

    name: str
    spoil: Spoil
    cause: str
    """Words that a message which names the true cause has all of; of `a|b` one."""
    robots: tuple[str, ...] = ROBOTS
    unobservable: tuple[str, ...] = ()
    """Robots on which nobody can see it: see `visibility.py`."""
    tolerance: Mapping[str, Any] | None = None
    """What in a robot file's `tolerances:` covers it: standard deviations, SI."""
    group: str = ""

    def is_named(self, message: str) -> bool:
        """Whether a message names the true cause."""
        text = message.lower()
        return all(
            any(word in text for word in words.split("|"))
            for words in self.cause.split()
        )


Groups = Mapping[str, tuple[Mistake, ...]]
