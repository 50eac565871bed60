"""Bodies and DH tables of a robot file as pydantic models."""

from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import (
    Direction,
    MappingSchema,
    Name,
    WrongValueError,
)
from orbident.robot.units import each_of, measure_of, quantity

MOMENTS, PRODUCTS = ("xx", "yy", "zz"), ("xy", "xz", "yz")

Place = Annotated[tuple[float, float, float], each_of("length")]
Angles = Annotated[tuple[float, float, float], each_of("angle")]


def _inertia(value: object) -> dict[str, float]:
    """`[xx, yy, zz]`, or a mapping that may have products too, in SI."""
    if isinstance(value, list | tuple) and len(value) == len(MOMENTS):
        value = dict(zip(MOMENTS, value, strict=True))
    if not isinstance(value, dict) or not set(MOMENTS) <= set(value):
        raise WrongValueError("give [xx, yy, zz] or {xx: .., yy: .., zz: .., xy: ..}")
    unknown = set(value) - {*MOMENTS, *PRODUCTS}
    if unknown:
        raise WrongValueError(f"give {', '.join((*MOMENTS, *PRODUCTS))} only")
    return {name: quantity(each, "inertia") for name, each in value.items()}


def _signed(dimension: str) -> BeforeValidator:
    return BeforeValidator(lambda value: quantity(value, dimension))


class MassEntry(MappingSchema):
    """Mass, CM and inertia of a body; a body without them has no mass."""

    mass: Annotated[float, measure_of("mass")] = 0.0
    com: Place = (0.0, 0.0, 0.0)
    inertia: Annotated[dict[str, float], BeforeValidator(_inertia)] | None = None

    @model_validator(mode="after")
    def _whole(self) -> "MassEntry":
        if self.mass and self.inertia is None:
            raise InputError(
                "'inertia' is missing, which every body with mass has; give it about "
                "the CM (zeros for a point)"
            )
        if not self.mass and (self.inertia is not None or any(self.com)):
            raise InputError(
                "'mass' is missing or zero; give it beside com and inertia"
            )
        return self

    @property
    def I_com(self) -> Float[np.ndarray, "3 3"]:
        """About the CM, body's axes, kg m^2; zero where there is none."""
        given = self.inertia or {}
        return np.array(
            [[given.get("".join(sorted(a + b)), 0.0) for b in "xyz"] for a in "xyz"]
        )


class BodyEntry(MassEntry):
    """A body, and the joint that it hangs on; the base has no parent."""

    parent: Name | None = None
    joint: Name | None = None
    type: Literal["revolute", "prismatic", "fixed"] = "revolute"
    axis: Direction | None = None
    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _hung(self) -> "BodyEntry":
        needed = {"joint": self.joint, "axis": self.axis}
        if self.parent is None:
            given = sorted(
                {"joint", "type", "axis", "xyz", "rpy"} & self.model_fields_set
            )
            if given:
                raise InputError(
                    f"{' and '.join(map(repr, given))} given, but no parent; add "
                    "'parent', or leave them out if this is the base"
                )
        elif self.type != "fixed":
            missing = [key for key, value in needed.items() if value is None]
            if missing:
                raise InputError(
                    f"{' and '.join(map(repr, missing))} missing; a body that moves on "
                    "its parent needs its joint's name and axis"
                )
        return self


class DhBase(MassEntry):
    """The base of a DH table, and where the table's frame 0 is in it."""

    name: Name = "base"
    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)


class DhRow(MassEntry):
    """A row of a DH table: a joint, and the link behind it."""

    joint: Name
    link: Name | None = None
    type: Literal["revolute", "prismatic"] = "revolute"
    a: Annotated[float, _signed("length")] = 0.0
    alpha: Annotated[float, _signed("angle")] = 0.0
    d: Annotated[float, _signed("length")] = 0.0
    theta: Annotated[float, _signed("angle")] = 0.0


class DhTable(MappingSchema):
    """One arm on a base after Denavit and Hartenberg."""

    convention: Literal["standard", "modified"] = "standard"
    base: DhBase
    rows: tuple[DhRow, ...] = Field(min_length=1)
