"""Bodies and DH tables of a robot file as pydantic models, and as links and joints.

A row of a DH table with `a`, `alpha`, `d`, `theta` puts frame `i` where

    standard:  T = Rz(theta) Tz(d) Tx(a) Rx(alpha),  joint `i` about z of frame i - 1,
    modified:  T = Rx(alpha) Tx(a) Rz(theta) Tz(d),  joint `i` about z of frame i,

after frame `i - 1`; the joint's angle is added to `theta`, its way to `d`.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import Direction, MappingSchema, Name, WrongValueError
from orbident.robot.units import each_of, measure_of, quantity, quantity_of
from orbident.robot.urdf import Urdf, UrdfJoint, UrdfLink, rotation_of

MOMENTS, PRODUCTS = ("xx", "yy", "zz"), ("xy", "xz", "yz")

Place = Annotated[tuple[float, float, float], each_of("length")]
Angles = Annotated[tuple[float, float, float], each_of("angle")]


def _inertia(value: object) -> dict[str, float]:
    """`[xx, yy, zz]`, or a mapping that may have products too, in SI."""
    if isinstance(value, list | tuple) and len(value) == len(MOMENTS):
        value = dict(zip(MOMENTS, value, strict=True))
    if not isinstance(value, dict) or not set(MOMENTS) <= set(value):
        raise WrongValueError("give [xx, yy, zz] or {xx: .., yy: .., zz: .., xy: ..}")
    if set(value) - {*MOMENTS, *PRODUCTS}:
        raise WrongValueError(f"give {', '.join((*MOMENTS, *PRODUCTS))} only")
    return {name: quantity(each, "inertia") for name, each in value.items()}


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

    def as_link(
        self, name: str, origin: Float[np.ndarray, "3"] | None = None
    ) -> UrdfLink:
        """The link whose mass is given in a frame that stands at `origin` in its own.

        The origin is in m; where absent, it is that of the link.
        """
        at = np.zeros(3) if origin is None else origin
        com = at + self.com if self.mass else np.zeros(3)
        return UrdfLink(name, self.mass, com, self.I_com)


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
            missing = [key for key in ("joint", "axis") if getattr(self, key) is None]
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
    a: Annotated[float, quantity_of("length")] = 0.0
    alpha: Annotated[float, quantity_of("angle")] = 0.0
    d: Annotated[float, quantity_of("length")] = 0.0
    theta: Annotated[float, quantity_of("angle")] = 0.0


class DhTable(MappingSchema):
    """One arm on a base after Denavit and Hartenberg."""

    convention: Literal["standard", "modified"] = "standard"
    base: DhBase
    rows: tuple[DhRow, ...] = Field(min_length=1)


def tree_of_bodies(bodies: Mapping[str, BodyEntry], name: str, place: str) -> Urdf:
    """The links and joints of `bodies:`.

    Each body stands in the frame of its joint.
    """
    links = tuple(entry.as_link(body) for body, entry in bodies.items())
    joints = tuple(
        UrdfJoint(
            entry.joint or f"{body}_fixed",
            entry.type,
            entry.parent,
            body,
            rotation_of(np.array(entry.rpy)),
            np.array(entry.xyz),
            np.array(entry.axis or (1.0, 0.0, 0.0)),
        )
        for body, entry in bodies.items()
        if entry.parent is not None
    )
    return Urdf(name, links, joints, place)


def tree_of_table(table: DhTable, name: str, place: str) -> Urdf:
    """The links and joints of `dh:`.

    A link's frame has the axes of its DH frame, and stands at its joint. With the
    standard convention that is beside the DH frame, at the origin of the one before.
    Mass, CM and inertia of a link are given in its DH frame.
    """
    parent, base = table.base.name, table.base
    links, joints = [base.as_link(parent)], []
    # Frame i - 1 in the parent's link frame.
    R, p = rotation_of(np.array(base.rpy)), np.array(base.xyz)
    for k, row in enumerate(table.rows, start=1):
        R_x = rotation_of(np.array([row.alpha, 0.0, 0.0]))
        R_z = rotation_of(np.array([0.0, 0.0, row.theta]))
        along, axis = np.array([row.a, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        # The joint from frame i - 1, in its axes; frame i from the joint, in i's axes.
        if table.convention == "modified":
            R_row, to_joint = R_x @ R_z, along + R_x @ (row.d * axis)
            behind = np.zeros(3)
        else:
            R_row, to_joint = R_z @ R_x, np.zeros(3)
            axis = R_x.T @ axis
            behind = along + row.d * axis
        link = row.link or f"link{k}"
        links.append(row.as_link(link, behind))
        joints.append(
            UrdfJoint(
                row.joint, row.type, parent, link, R @ R_row, p + R @ to_joint, axis
            )
        )
        parent, R, p = link, np.eye(3), behind
    return Urdf(name, tuple(links), tuple(joints), place)
