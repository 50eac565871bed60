"""What errors of instruments that are taken for zero would shift."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from orbident.errors import InputError
from orbident.files.json_parts import JsonPart, NullableTable


@dataclass(frozen=True, repr=False)
class SensitivityTable(JsonPart):
    """Shifts of the base parameters, in their own standard deviations."""

    parameters: tuple[str, ...]
    errors: tuple[str, ...]
    """Such as `joint.elbow.zero`."""
    units: tuple[str, ...]
    """The unit of each error: shifts are for one mrad, mm, % or ms."""
    shifts: Annotated[NullableTable, Field(alias="in_deviations")]
    """A row a parameter, a column an error; NaN for a parameter that is not determined.
    """

    def __post_init__(self) -> None:
        """Refuse a table that lacks a row or a column."""
        rows, columns = len(self.parameters), len(self.errors)
        if self.shifts.shape != (rows, columns) or len(self.units) != columns:
            raise InputError(f"the table is not {rows} by {columns}")

    def __repr__(self) -> str:
        """How large it is, and the largest shift by an instrument."""
        size = f"{len(self.parameters)} parameters, {len(self.errors)} errors"
        if not self.errors:
            return size
        error, unit, parameter, shift = self.worst()
        return (
            f"{size}; 1 {unit} of {error} shifts {parameter} most, by {shift:.3g} of "
            "its deviations"
        )

    def worst(self) -> tuple[str, str, str, float]:
        """The error that shifts most, its unit, what, and by how much."""
        size = np.nan_to_num(np.abs(self.shifts))
        row, column = np.unravel_index(size.argmax(), size.shape)
        where = self.errors[column], self.units[column], self.parameters[row]
        return *where, float(size[row, column])
