"""What errors of instruments that are taken as exact would shift."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.estimation.quantities import nulled


@dataclass(frozen=True)
class SensitivityTable:
    """Shifts of the base parameters, in their own standard deviations."""

    parameters: tuple[str, ...]
    errors: tuple[str, ...]
    """Such as `joint.elbow.zero`."""
    units: tuple[str, ...]
    """The unit of each error: shifts are for one mrad, mm or %."""
    shifts: Float[np.ndarray, "parameters errors"]
    """NaN for a parameter that is not determined."""

    def worst(self) -> tuple[str, str, str, float]:
        """The error that shifts most, its unit, which parameter, and by how much."""
        size = np.nan_to_num(np.abs(self.shifts))
        row, column = np.unravel_index(size.argmax(), size.shape)
        where = self.errors[column], self.units[column], self.parameters[row]
        return *where, float(size[row, column])

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`."""
        return {
            "parameters": list(self.parameters),
            "errors": list(self.errors),
            "units": list(self.units),
            "in_deviations": [nulled(row) for row in self.shifts],
        }
