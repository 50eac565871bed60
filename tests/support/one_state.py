"""The one state in results that are stacked over states."""

from typing import NamedTuple, TypeVar

Parts = TypeVar("Parts", bound=NamedTuple)


def only_state(stacked: Parts) -> Parts:
    """The first state's arrays, without the leading axis of the states."""
    return stacked._make(part[0] for part in stacked)
