"""Numbers with standard deviations: one, or a named set of them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Parameters:
    """A set of parameters; NaN where the recording does not determine one."""

    names: tuple[str, ...]
    formulas: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    std: Float[np.ndarray, " n"]

    def __iter__(self) -> Iterator[tuple[str, str, float, float]]:
        """Name, formula, value and standard deviation of each."""
        return zip(self.names, self.formulas, self.values, self.std, strict=True)

    def undetermined(self) -> "Parameters":
        """The same names, without values."""
        nothing = np.full_like(self.values, np.nan)
        return Parameters(self.names, self.formulas, nothing, nothing)

    def to_json(self) -> dict[str, Any]:
        """As in `result.json`: null for NaN."""
        return {
            "names": list(self.names),
            "formulas": list(self.formulas),
            "values": nulled(self.values),
            "std": nulled(self.std),
        }


@dataclass(frozen=True)
class Quantity:
    """One number and its standard deviation; NaN where it is not determined."""

    value: float
    std: float


def nulled(numbers: Float[np.ndarray, " n"] | float) -> Any:
    """Numbers as JSON has them: null for what is not finite."""
    if isinstance(numbers, np.ndarray):
        return [nulled(float(number)) for number in numbers]
    return float(numbers) if np.isfinite(numbers) else None
