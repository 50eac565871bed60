"""What a bag says of its topics, and how a message's bytes are read."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from orbident.errors import InputError
from orbident.files.names import one_line
from orbident.recordings.bags.libraries import (
    MessageDefinitionFormat,
    Stores,
    TopicInfo,
    Typestore,
    get_types_from_msg,
    get_typestore,
)


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    type: str
    """Without `/msg/`: `sensor_msgs/Imu`."""
    count: int
    """Messages."""
    encoding: str
    """`ros1` and `cdr` can be read."""
    definition: str = field(repr=False)
    """The message definition that the bag carries; empty where it has none."""

    @property
    def is_defined(self) -> bool:
        """Whether its messages can be decoded."""
        with suppress(InputError):
            self.decoder("")
            return True
        return False

    def decoder(self, place: str) -> Callable[[bytes], Any]:
        """What turns a message's bytes into the message, or None if they are not one.

        The bag's own definition of the type is used, else ROS's.

        Raises:
            InputError: the encoding is none of ROS, or the definition cannot be read.
        """
        name = self.type.replace("/", "/msg/")
        known = {"ros1": Stores.ROS1_NOETIC, "cdr": Stores.ROS2_HUMBLE}
        if self.encoding not in known:
            raise InputError(
                f"{place}: topic '{self.name}' is encoded as {self.encoding!r}; only "
                "ROS messages (ros1, cdr) can be read"
            )
        if self.definition:
            store = get_typestore(Stores.EMPTY)
            try:
                store.register(get_types_from_msg(self.definition, name))
            except Exception as error:
                raise InputError(
                    f"{place}: topic '{self.name}': the definition of {self.type} "
                    f"cannot be read ({one_line(error)})"
                ) from error
            for part, field in _missing(store):
                raise InputError(
                    f"{place}: topic '{self.name}': its {self.type} is not ROS's: "
                    f"{part} has no '{field}' as it has there; convert its messages "
                    "to the standard type"
                )
        else:
            store = get_typestore(known[self.encoding])
            if name not in store.fielddefs:
                raise InputError(
                    f"{place}: topic '{self.name}': the file has no definition of "
                    f"{self.type}; record as MCAP, or by ROS 2 from Jazzy on"
                )
        read = (
            store.deserialize_ros1 if self.encoding == "ros1" else store.deserialize_cdr
        )

        def decoded(data: bytes) -> Any:
            # Bytes that are not of their type raise errors of many kinds.
            with suppress(Exception):
                return read(data, name)
            return None

        return decoded


def _missing(store: Typestore) -> Iterator[tuple[str, str]]:
    """Types of ROS as a bag defines them, and fields that each lacks or has changed.

    A ROS 1 header has all that a ROS 2 header has, and so have the other types.
    """
    standard = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    for name, (_, fields) in store.fielddefs.items():
        _, expected = standard.get(name, ([], []))
        for one in expected:
            if one not in fields:
                yield short_type(name), one[0]


def by_name(topics: Iterable[Topic]) -> dict[str, Topic]:
    """One topic for all of its name."""
    found: dict[str, Topic] = {}
    for each in topics:
        same = found.get(each.name, each)
        kind = each.type if each.type == same.type else f"{same.type} and {each.type}"
        before = 0 if same is each else same.count
        found[each.name] = replace(each, type=kind, count=before + each.count)
    return found


def short_type(name: str) -> str:
    """`sensor_msgs/msg/Imu` as ROS 1 writes it: `sensor_msgs/Imu`."""
    return name.replace("/msg/", "/")


def described(name: str, info: TopicInfo, encoding: str) -> Topic:
    """A topic as the library rosbags describes it."""
    types = sorted({short_type(each.msgtype) for each in info.connections})
    plain = info.msgdef.format == MessageDefinitionFormat.MSG
    text = info.msgdef.data if plain else ""
    return Topic(name, " and ".join(types), info.msgcount, encoding, text)
