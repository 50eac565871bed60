"""Distributions by name: what a quantity of a campaign is drawn from."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.bounds import LARGEST
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import WrongValueError
from orbident.robot.units import quantity

Kind = Literal["normal", "uniform", "signs"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
class Distribution:
    """A distribution about zero, unless it is uniform between other ends.

    `normal: s` has the standard deviation `s`; `uniform: [a, b]` is between `a` and
    `b`; `signs: s` is `s` or `-s`, each as often.
    """

    kind: Kind
    numbers: tuple[float, ...]

    def draw(self, random: np.random.Generator, n: int) -> Float[np.ndarray, " n"]:
        """So many independent numbers."""
        if self.kind == "uniform":
            return random.uniform(self.numbers[0], self.numbers[-1], n)
        (size,) = self.numbers
        if self.kind == "signs":
            return random.choice([-size, size], n)
        return size * random.standard_normal(n)


def drawn_from(dimension: str, largest: float = LARGEST) -> BeforeValidator:
    """Reads a distribution from a file, as `{normal: 0.1}`.

    Args:
        dimension: of the quantity, as `robot.units` has it.
        largest: magnitude of its numbers.
    """

    def read(value: object) -> Distribution:
        if not isinstance(value, dict) or len(value) != 1:
            raise WrongValueError(
                "give one distribution with its numbers, such as {normal: 0.1}"
            )
        ((name, given),) = value.items()
        if name not in KINDS:
            known = suggestion(str(name), KINDS, "distributions")
            raise InputError(f"unknown distribution {quoted(name)}; {known}")
        numbers = _numbers(name, given, dimension)
        if max(map(abs, numbers)) > largest:
            raise WrongValueError(f"give {name} numbers of at most {largest:g}")
        return Distribution(name, numbers)

    return BeforeValidator(read)


def _numbers(kind: Kind, given: object, dimension: str) -> tuple[float, ...]:
    if kind != "uniform":
        size = quantity(given, dimension)
        if size < 0:
            raise WrongValueError(f"give {kind} a size of zero or more")
        return (size,)
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise WrongValueError("give uniform: [lower, upper]")
    low, high = (quantity(each, dimension) for each in given)
    if low > high:
        raise WrongValueError("give uniform: [lower, upper] with lower below upper")
    return low, high
