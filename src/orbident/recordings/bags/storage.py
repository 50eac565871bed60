"""What each kind of bag gives: its topics, and a stream of messages."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

from orbident.recordings.bags.topic import RawMessage, Topic


@dataclass(frozen=True)
class Storage:
    """An open bag."""

    topics: Sequence[Topic]
    messages: Callable[[Collection[str]], Iterator[RawMessage]]
    """All messages of these topics, one chunk of the file in memory at a time."""
    notes: tuple[str, ...] = ()
    """Warnings: what of the bag is missing."""
