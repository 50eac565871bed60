"""A file of another tool that is open: its topics, and what comes on them."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from orbident.errors import InputError
from orbident.files.names import closest, listed


class RawMessage(NamedTuple):
    """What came on a topic, as the file has it."""

    topic: str
    received: int
    """When it was recorded, ns since the epoch of the recorder's clock."""
    data: Any
    """The bytes of a message, or a whole table."""


@dataclass(frozen=True)
class Source:
    """What is in a file: streams of messages, or tables."""

    path: Path
    topics: Mapping[str, Any]
    """A `Topic` of a bag or a `Group`, by name."""
    messages: Callable[[Collection[str]], Iterator[RawMessage]]
    """Every message of these topics, in the order of the file or of its index; one
    chunk of the file is in memory at a time."""
    notes: tuple[str, ...] = ()
    """Warnings: what of the file is missing."""

    def topic(self, name: str) -> Any:
        """A topic that has messages.

        Raises:
            InputError: the file does not have it, or has no message of it.
        """
        if name not in self.topics:
            close = closest(name, self.topics)
            hint = f"did you mean '{close}'? " if close else ""
            raise InputError(
                f"{self.path}: has no topic '{name}'; {hint}it has "
                + listed(self.topics)
            )
        if not self.topics[name].count:
            raise InputError(
                f"{self.path}: topic '{name}' has no messages; take it out of the map, "
                "or record again"
            )
        return self.topics[name]
