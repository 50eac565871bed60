"""How a map names the numbers that a column is made of."""

import math
import re
from typing import NamedTuple

from orbident.files.schema_parts import WrongValueError

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_SLOT = re.compile(
    rf"(?P<minus>-?)\s*(?:(?P<factor>{_NUMBER})\s*\*\s*)?(?P<field>\S|\S.*?\S)"
    rf"(?:\s+(?P<offset>[-+]\s+{_NUMBER}))?",
    re.DOTALL,
)


class Slot(NamedTuple):
    """One number of a sample, `factor * field + offset`."""

    field: str
    """Which field it is of; empty for a number that is always the same."""
    factor: float
    offset: float = 0.0


def slots_of(value: object) -> tuple[Slot, ...] | Slot:
    """`x`, `-x`, `0.4 * x + 3` or a number as one slot; a list of them as several."""
    if isinstance(value, list | tuple):
        return tuple(_slot(each) for each in value)
    return _slot(value)


def _slot(value: object) -> Slot:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return Slot("", 0.0, float(value))
    found = _SLOT.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        raise WrongValueError(
            "give a field, a field with a minus before it, counts as '0.4 * field + "
            "3', or a list of these, such as [wx, -wy, 0]"
        )
    factor = float(found["factor"] or 1) * (-1 if found["minus"] else 1)
    offset = "".join((found["offset"] or "0").split())
    if not (math.isfinite(factor) and math.isfinite(float(offset))):
        raise WrongValueError("give numbers that are finite")
    return Slot(found["field"], factor, float(offset))
