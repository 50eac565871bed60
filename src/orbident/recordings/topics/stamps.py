"""The times of a table: a field that holds them, or several that are added."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Int

from orbident.errors import InputError
from orbident.files.schema_parts import WrongValueError
from orbident.recordings.logs.group import Group
from orbident.recordings.topics.declared_units import TIMES, nanoseconds_of

_MOST = 2**62
"""ns, 146 years; so far the sum of the fields goes."""


def stamp_fields(value: object) -> dict[str, str]:
    """The value of `stamp`: `{time: us}`, or `{sec: s, nanosec: ns}`.

    Raises:
        WrongValueError: it is another.
    """
    if isinstance(value, dict) and value:
        units = {str(field): str(unit) for field, unit in value.items()}
        if all(nanoseconds_of(unit) for unit in units.values()):
            return units
    raise WrongValueError(
        "give the field that holds the time, and its unit: {time: s}, with one of "
        f"{', '.join(TIMES)}, or '0.2 s' for counts; several fields are added"
    )


def stamps_of(fields: Mapping[str, str], group: Group) -> Int[np.ndarray, " n"]:
    """The sum of the fields, ns.

    Args:
        fields: their units by name.
        group: where they are.

    Raises:
        InputError: a field is missing or holds no numbers, the file says that it is in
            another unit, a time is not finite, or beyond 146 years.
    """
    stamps = np.zeros(0, dtype=np.int64)
    for number, (field, unit) in enumerate(fields.items()):
        values = group.column(field)
        where = f"{group.place}: topic '{group.name}': time '{field}'"
        known = group.unit(field)
        if unit in TIMES and known in TIMES and known != unit:
            raise InputError(
                f"{where} is in {known} in the file, where dates are in ns, but in "
                f"{unit} in the map; write stamp: {{{field}: {known}}}"
            )
        if number and values.size != stamps.size:
            raise InputError(
                f"{where} has {values.size} values, but the other part of the time has "
                f"{stamps.size}; give fields of one length"
            )
        part = _nanoseconds(values, unit, where, _MOST // len(fields))
        stamps = stamps + part if number else part
    return stamps


def _nanoseconds(
    values: np.ndarray, unit: str, where: str, most: int
) -> Int[np.ndarray, " n"]:
    factor = nanoseconds_of(unit) or 1
    finite = np.isfinite(values)
    if not finite.all():
        row = int(np.argmin(finite)) + 1
        raise InputError(
            f"{where}, row {row}: found {values[row - 1]}; every row needs a time"
        )
    if np.abs(values.astype(np.float64)).max(initial=0.0) * factor > most:
        raise InputError(
            f"{where} goes beyond 146 years in {unit}; correct the unit, one of "
            + ", ".join(TIMES)
        )
    if values.dtype.kind in "iu":
        return values.astype(np.int64) * factor
    return np.round(values * factor).astype(np.int64)
