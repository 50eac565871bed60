"""How a map names the numbers that a column is made of."""

from typing import NamedTuple

from orbident.files.schema_parts import WrongValueError


class Slot(NamedTuple):
    """One number of a sample."""

    field: str
    """Which field it is of; empty for a number that is always the same."""
    factor: float
    """1 or -1, or the number."""


def slots_of(value: object) -> tuple[Slot, ...] | Slot:
    """`x`, `-x` or a number as one slot; a list of them as several."""
    if isinstance(value, list | tuple):
        return tuple(_slot(each) for each in value)
    return _slot(value)


def _slot(value: object) -> Slot:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return Slot("", float(value))
    if not isinstance(value, str) or not value.removeprefix("-"):
        raise WrongValueError(
            "give a field, a field with a minus before it, or a list of these, such as "
            "[wx, -wy, 0]"
        )
    return Slot(value.removeprefix("-"), -1.0 if value.startswith("-") else 1.0)
