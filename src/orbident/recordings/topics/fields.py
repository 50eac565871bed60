"""Fields of numbers into columns, of messages and of tables in files."""

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from itertools import accumulate
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from jaxtyping import Float, Int
from pydantic import BeforeValidator, Field, model_validator

from orbident.errors import InputError
from orbident.files.schema_parts import Name, WrongValueError, finite_vector
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.recordings.logs.group import Group
from orbident.recordings.topics.entry import LONGEST, Entry
from orbident.recordings.topics.targets import (
    AT_S,
    DIMENSIONS,
    TIMES,
    TURNED,
    Slot,
    Target,
    conjugate,
    nanoseconds_of,
    product,
    slots_of,
    target_of,
)


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
    """The sum of the fields, whose units are given by name, ns.

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
        part = _nanoseconds(values, unit, where, LONGEST // len(fields))
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
    # Not times the factor, which overflows.
    if np.abs(values.astype(np.float64)).max(initial=0.0) > most / factor:
        raise InputError(
            f"{where} goes beyond 146 years in {unit}; correct the unit, one of "
            + ", ".join(TIMES)
        )
    if values.dtype.kind in "iu":
        return values.astype(np.int64) * factor
    return np.round(values * factor).astype(np.int64)


def _rotation(value: object) -> tuple[float, ...]:
    quaternion = finite_vector(value, 4)
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1) > 0.01:
        raise InputError(f"its norm is {norm:.4g}; give a unit quaternion, scalar last")
    return tuple(each / norm for each in quaternion)


class Filling(Entry):
    """What fills columns with numbers: of a message, or of fields.

    Its sensor is turned against the base, `x_BS`, and may be at S.
    """

    frame: Literal["base"] | None = None
    rotation: (
        Annotated[tuple[float, float, float, float], BeforeValidator(_rotation)] | None
    ) = None
    point: Literal["S"] | None = None

    @property
    @abstractmethod
    def targets(self) -> list[Target]:
        """What is filled."""

    @property
    def read(self) -> list[Target]:
        """What a sample's values are of, in their order: the targets first."""
        return self.targets

    @model_validator(mode="after")
    def _stated(self) -> "Filling":
        # Of `gyro.z` it is the gyro.
        sensors = dict.fromkeys(each.name.split(".")[0] for each in self.targets)
        turned = [each for each in sensors if each in TURNED]
        if turned and (self.frame is None) == (self.rotation is None):
            found = "neither" if self.frame is None else "both"
            raise InputError(
                f"{found} of frame and rotation given for {', '.join(turned)}; give "
                "'frame: base' if the axes are the base's, else 'rotation: [x, y, z, "
                "w]', which turns vectors from the sensor's axes to the base's"
            )
        placed = [each for each in sensors if each in AT_S]
        if placed and self.point is None:
            raise InputError(
                f"point missing for {', '.join(placed)}; give 'point: S' if the place "
                "that is measured is the robot's feature_point, else move that there"
            )
        return self

    @property
    def columns(self) -> tuple[str, ...]:
        """Those of every target."""
        return tuple(name for target in self.targets for name in target.columns)

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where in a sample's values each of `read` stands."""
        ends = accumulate(target.width for target in self.read)
        return {
            t.name: slice(k - t.width, k) for t, k in zip(self.read, ends, strict=True)
        }

    @property
    def quaternion(self) -> slice | None:
        """Where the attitude stands, if it is a quaternion."""
        found = (self.slices[t.name] for t in self.read if t.unit.name == "quaternion")
        return next(found, None)

    def table(self, raw: Float[np.ndarray, "n K"]) -> Float[np.ndarray, "n columns"]:
        """The columns in SI and base axes: `v_B = R_BS v_S`, `R_WB = R_WS R_BS^T`."""
        parts = []
        for target in self.targets:
            values = target.in_si(raw[:, self.slices[target.name]])
            # Turning by nothing would let a NaN of one axis into the others.
            if self.rotation is not None and target.name in TURNED:
                x_BS = np.array([self.rotation])
                if target.name == "attitude":
                    values = product(values, conjugate(x_BS))
                else:
                    values = rotate(quaternion_matrix(x_BS), values)
            parts.append(values)
        return np.hstack(parts)


class Fields(Filling):
    """`take` says which columns are filled, `fields` from what, axis by axis."""

    take: Mapping[Name, Any] = Field(min_length=1)
    fields: Mapping[Name, Annotated[Any, BeforeValidator(slots_of)]] = Field(
        default_factory=dict
    )
    stamp: Annotated[Mapping[str, str], BeforeValidator(stamp_fields)] = Field(
        default_factory=dict
    )
    """The fields whose sum is the time, with their units."""

    @property
    def counts(self) -> tuple[int, ...]:
        """Nanoseconds of one unit of each field that is part of the time."""
        return tuple(nanoseconds_of(unit) or 1 for unit in self.stamp.values()) or (1,)

    @property
    def targets(self) -> list[Target]:
        """What is filled, in the order of the map.

        Raises:
            InputError: a column that numbers cannot fill, or a unit that is none of it.
        """
        return [target_of(name, unit) for name, unit in self.take.items()]

    @cached_property
    def slots(self) -> list[Slot]:
        """The numbers of a sample, in the order of the targets.

        Raises:
            InputError: the fields of a target are missing, or too many or too few.
        """
        return [slot for target in self.targets for slot in self._slots_of(target)]

    @model_validator(mode="after")
    def _consistent(self) -> "Fields":
        _ = self.slots
        for name in self.fields:
            if name not in self.take:
                raise InputError(
                    f"fields: '{name}' is not in take; add it there with its unit, or "
                    "take it out here"
                )
        single = [t.name for t in self.targets if t.part_of_turned]
        if single and self.rotation:
            raise InputError(
                f"rotation: '{single[0]}' is one axis, which cannot be turned; take "
                f"'{single[0].split('.')[0]}' with three fields"
            )
        return self

    def _slots_of(self, target: Target) -> tuple[Slot, ...]:
        given = self.fields.get(target.name)
        if given is None:
            raise InputError(
                f"fields: '{target.name}' is missing; name what it is made of, such as "
                f"fields: {{{target.name}: {target.example}}}"
            )
        if isinstance(given, Slot):
            # A field with as many columns as are wanted.
            if target.width == 1 or not given.field:
                return (given,) * target.width
            parts = range(target.width)
            return tuple(given._replace(field=f"{given.field}.{k}") for k in parts)
        if len(given) != target.width:
            raise InputError(
                f"fields: '{target.name}' has {len(given)} fields; give "
                f"{target.width}: {target.example}"
            )
        return given


class Table(Fields):
    """Fields over one time: a struct, a group, a topic of a log, a whole file."""

    stamp: Annotated[Mapping[str, str], BeforeValidator(stamp_fields)] = Field()
    time: Literal["header", "receive"] = "receive"
    other_time: ClassVar[str] = "stamp"

    @model_validator(mode="after")
    def _no_other_time(self) -> "Table":
        if "time" in self.model_fields_set:
            raise InputError("time: a table's is in 'stamp'; leave this key out")
        return self

    def rows(
        self, group: Group
    ) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, "n K"]]:
        """Times, ns, and every slot's values.

        Raises:
            InputError: a field is missing, holds no numbers, or has another length
                than the time; a time is not finite; the file has it in another unit.
        """
        times = stamps_of(self.stamp, group)
        self._check_units(group)
        raw = np.empty((times.size, len(self.slots)))
        for k, slot in enumerate(self.slots):
            if not slot.field:
                raw[:, k] = slot.offset
                continue
            # Before it is read: a damaged file may say that it is any size.
            samples = group.samples(slot.field)
            if samples != times.size:
                raise InputError(
                    f"{group.place}: topic '{group.name}': field '{slot.field}' has "
                    f"{samples} values, but '{next(iter(self.stamp))}' has "
                    f"{times.size}; name the time of this field in an entry of its own"
                )
            # What is beyond all numbers is no sample, as in the file itself.
            with np.errstate(over="ignore"):
                raw[:, k] = slot.factor * group.column(slot.field) + slot.offset
        return times, raw

    def _check_units(self, group: Group) -> None:
        """Refuses a unit that the file itself says is another one."""
        for target in self.targets:
            unit = target.unit
            units = DIMENSIONS.get(unit.dimension, {})
            for slot in self._slots_of(target):
                known = group.unit(slot.field)
                scaled = abs(slot.factor) != 1 or slot.offset
                if not scaled and units.get(known, unit.si) != unit.si:
                    raise InputError(
                        f"{group.place}: topic '{group.name}': field '{slot.field}' is "
                        f"in {known} in the file, but in {unit.name} in the map; "
                        "correct the map, or the file"
                    )


def missing_of(entry: Entry, topics: Mapping[str, Any]) -> tuple[str, str] | None:
    """What of a file an entry needs and the file has not: `("field", "q1")`, or None.

    The first is "topic" or "field", the other its name.
    """
    topic = topics.get(entry.topic)
    if topic is None or not topic.count:
        return "topic", entry.topic
    if not (isinstance(entry, Table) and isinstance(topic, Group)):
        return None
    named = [*entry.stamp, *(slot.field for slot in entry.slots if slot.field)]
    return next((("field", name) for name in named if not topic.has(name)), None)
