"""What is in a bag: topics, their rates, and an example of each."""

import os
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from orbident.recordings.bags.bag import Bag, open_bag
from orbident.recordings.bags.topic import Topic
from orbident.recordings.bags.topic_map import MESSAGE_TYPES

_EXAMPLES = 200
_SAID_EVERY = 4096


@dataclass(frozen=True)
class Surveyed:
    """One topic."""

    topic: Topic
    rate: float | None
    """Hz, on the recorder's clock; None for fewer than two messages."""
    labels: tuple[str, ...] = ()
    """Names of joints or of transforms, in the order in which they come."""
    example: Any = None
    """Its first message, where the type can be mapped."""


def survey_bag(
    bag: str | os.PathLike[str], progress: Callable[[float], None] | None = None
) -> tuple[Surveyed, ...]:
    """Lists a bag's topics, by name; it is read once, whole.

    Args:
        bag: a ROS 1 bag, a ROS 2 bag, or an MCAP file.
        progress: called with the fraction done.

    Raises:
        InputError: It is no bag, damaged or empty.
    """
    with open_bag(Path(bag)) as opened:
        names = sorted(opened.topics)
        looked = _looked_through(opened, progress or (lambda fraction: None))
        return tuple(_surveyed(opened.topics[name], looked[name]) for name in names)


@dataclass
class _Look:
    """What has been seen of a topic so far."""

    count: int = 0
    first: int = 0
    last: int = 0
    labels: dict[str, None] = field(default_factory=dict)
    example: Any = None


def _looked_through(bag: Bag, said: Callable[[float], None]) -> dict[str, _Look]:
    decoders = {
        name: topic.decoder(str(bag.path))
        for name, topic in bag.topics.items()
        if topic.type in MESSAGE_TYPES and topic.encoding in {"ros1", "cdr"}
    }
    total = sum(topic.count for topic in bag.topics.values())
    looks = defaultdict(_Look)
    for number, (name, received, data) in enumerate(bag.messages(bag.topics)):
        look = looks[name]
        look.first = min(look.first, received) if look.count else received
        look.last = max(look.last, received)
        if name in decoders and look.count < _EXAMPLES:
            message = decoders[name](data)
            if message is not None:
                labels = MESSAGE_TYPES[bag.topics[name].type].labels(message)
                look.labels.update(dict.fromkeys(labels))
                look.example = look.example or message
        look.count += 1
        if number % _SAID_EVERY == 0:
            said(min(number / total, 1.0))
    return looks


def _surveyed(topic: Topic, look: _Look) -> Surveyed:
    span = look.last - look.first
    rate = (look.count - 1) * 1e9 / span if span > 0 else None
    return Surveyed(topic, rate, tuple(look.labels), look.example)
