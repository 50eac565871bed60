"""The recording as plain frozen data: what was measured, and when."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from orbident.data_table import frame
from orbident.errors import InputError
from orbident.files.names import closest, counted, listed
from orbident.recordings.column_checks import (
    as_column,
    check_attitude,
    check_column,
    check_size,
    check_time,
)
from orbident.recordings.columns import (
    VECTORS,
    check_names,
    columns_in_words,
    is_known,
    meaning,
    part_of,
    vector_columns,
)
from orbident.recordings.simulators import columns_of_basilisk, columns_of_mujoco
from orbident.robot.description import Robot


@runtime_checkable
class NamedColumns(Protocol):
    """Columns by name: a mapping, or a `pandas.DataFrame`."""

    def keys(self) -> Iterable[Any]:
        """The names."""
        ...

    def __getitem__(self, name: Any, /) -> Any:
        """A column."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Measurements over time, one column a signal, SI units.

    NaN means that this sensor has no sample at this time. Columns without a meaning
    here are carried along unused. Float64 arrays are not copied: the recording holds
    read-only views of them. Rows are counted from 1 in messages.

    Raises:
        InputError: Fewer than two samples; times not finite or not strictly
            increasing; a column of another length, not numeric or with an infinite
            value; an attitude that is not a unit quaternion within 1 %. Quaternions of
            zeros among others are no samples, and become NaN.
    """

    t: Float[np.ndarray, " samples"]
    """Time, s."""
    columns: Mapping[str, Float[np.ndarray, " samples"]]
    """Columns by name, as in the file; without `t`."""
    source: str = "recording"
    """Where it came from, for messages."""
    notes: tuple[str, ...] = ()
    """What was no sample though it was a number, in words."""

    def __post_init__(self) -> None:
        t = as_column(self.source, "t", self.t)
        columns = {
            name: as_column(self.source, name, values)
            for name, values in self.columns.items()
        }
        object.__setattr__(self, "t", t)
        check_time(self.source, t)
        for name, values in columns.items():
            check_column(self.source, name, values, t.size)
        attitude = vector_columns("attitude")
        if columns.keys() >= set(attitude):
            zero = np.logical_and.reduce([columns[name] == 0 for name in attitude])
            if zero.all():
                raise InputError(
                    f"{self.source}: attitude: all {t.size} quaternions are zero, as "
                    "of a tracker that sees nothing; leave out 'attitude.x' to '.w'"
                )
            if zero.any():
                # So a tracker writes that it sees nothing.
                for name in attitude:
                    column = np.where(zero, np.nan, columns[name])
                    columns[name] = as_column(self.source, name, column)
                note = (
                    f"attitude: {counted(int(zero.sum()), 'quaternion')} of zeros left "
                    f"out, the first at t = {t[zero.argmax()]:g} s"
                )
                object.__setattr__(self, "notes", (*self.notes, note))
            check_attitude(self.source, [columns[name] for name in attitude])
        object.__setattr__(self, "columns", columns)
        for name, values in columns.items():
            check_size(self.source, name, values)

    @classmethod
    def of(cls, table: NamedColumns, source: str = "table") -> "Recording":
        """The recording that a mapping of columns or a `pandas.DataFrame` holds.

        Args:
            table: columns by name, SI, as in a file. `t` may be the frame's index. A
                vector may be one array of samples by components: `gyro` N x 3,
                `attitude` N x 4, scalar last.
            source: a name for messages.

        Raises:
            InputError: There is no `t`, an array has another number of components, or
                `Recording` refuses the values.
        """
        columns = list[tuple[str, Any]]()
        names = list(table.keys())
        for name in names:
            values = np.asarray(table[name])
            if name not in VECTORS:
                columns.append((str(name), values))
                continue
            parts = vector_columns(name)
            if values.ndim != 2 or values.shape[1] != len(parts):
                raise InputError(
                    f"{source}: '{name}' has shape {values.shape}; give samples by "
                    f"{len(parts)} components, or the columns {', '.join(parts)}"
                )
            columns += zip(parts, values.T, strict=True)
        index = getattr(table, "index", None)
        if getattr(index, "name", None) == "t":
            columns.append(("t", np.asarray(index)))
        check_names(source, [name for name, _ in columns])
        by_name = dict(columns)
        return cls(t=by_name.pop("t"), columns=by_name, source=source)

    @classmethod
    def from_mujoco(
        cls, robot: Robot, model: Any, t: ArrayLike, qpos: ArrayLike, qvel: ArrayLike
    ) -> "Recording":
        """The recording of a flight that MuJoCo has simulated, without noise.

        Args:
            robot: Its joints and wheels have the names of the model's joints.
            model: An `mujoco.MjModel` whose base floats on its only free joint.
            t: `MjData.time` of each row, s.
            qpos: The rows of `MjData.qpos`, samples by `nq`.
            qvel: The rows of `MjData.qvel`, samples by `nv`. Let the integrator be RK4:
                the momentum of the others is not constant.

        Raises:
            InputError: The arrays are not the model's, it lacks a joint of the robot,
                or `Recording` refuses the values.
        """
        rows = np.asarray(qpos, float), np.asarray(qvel, float)
        return cls.of({"t": t, **columns_of_mujoco(robot, model, *rows)}, "MuJoCo")

    @classmethod
    def from_basilisk(
        cls, robot: Robot, states: Any, wheels: Any = None, joints: Sequence[Any] = ()
    ) -> "Recording":
        """The recording of a flight that Basilisk has simulated, without noise.

        Args:
            robot: The hub's origin is that of its base link.
            states: The recorder of `scStateOutMsg`.
            wheels: The recorder of `rwSpeedOutMsg`: the robot's wheels in its order.
            joints: The recorders of `spinningBodyOutMsgs` (or of translating bodies),
                in the order of the robot's joints.

        Raises:
            InputError: There are more or fewer wheels or joints than the robot has,
                recorders differ in their times, or `Recording` refuses the values.
        """
        return cls.of(columns_of_basilisk(robot, states, wheels, joints), "Basilisk")

    def __repr__(self) -> str:
        """Where it is from, how long it is, and what was measured."""
        t = self.t
        head = f"{self.source}: {t.size} rows, t = {t[0]:.6g} to {t[-1]:.6g} s"
        return "\n".join([head, *columns_in_words(self.columns)])

    def to_frame(self) -> Any:
        """The columns over `t` as a `pandas.DataFrame`; NaN: no sample of this sensor.

        Raises:
            MissingLibraryError: pandas is not installed.
        """
        return frame(self.columns, self.t, "t")

    def with_columns(
        self, columns: Mapping[str, Float[np.ndarray, " samples"]]
    ) -> "Recording":
        """The recording with these columns in the place of its own, or beside them."""
        return replace(self, columns={**self.columns, **columns})

    def between(self, start: float = -math.inf, end: float = math.inf) -> "Recording":
        """The rows whose times are from `start` to `end`, s, both included.

        Raises:
            InputError: There are fewer than two such rows.
        """
        rows = within(self.t, start, end)
        check_cut(self.source, start, end, int(rows.sum()), self.t[0], self.t[-1])
        return self.some(rows)

    def some(self, rows: slice | Bool[np.ndarray, " samples"]) -> "Recording":
        """These rows alone."""
        columns = {name: column[rows] for name, column in self.columns.items()}
        return replace(self, t=self.t[rows], columns=columns)

    def has(self, *names: str) -> bool:
        """Whether every one of these columns is there."""
        return all(name in self.columns for name in names)

    def has_vector(self, name: str) -> bool:
        """Whether a sensor is there.

        Raises:
            InputError: Only some of its components are.
        """
        columns = vector_columns(name)
        return any(map(self.has, columns)) and all(self.column(x).size for x in columns)

    def column(self, name: str) -> Float[np.ndarray, " samples"]:
        """One column, without a copy.

        Raises:
            InputError: The column is missing.
        """
        if name in self.columns:
            return self.columns[name]
        purpose = f" ({meaning(name)})" if meaning(name) else ""
        strangers = [
            other
            for other in self.columns
            if not (is_known(other) or other.startswith("truth."))
        ]
        close = closest(name, strangers)
        rename = f", or rename '{close}' if it is that" if close else ""
        raise InputError(
            f"{self.source}: column '{name}' is missing{purpose}; add it{rename}"
        )

    def vector(
        self, prefix: str, components: str | None = None
    ) -> Float[np.ndarray, "samples K"]:
        """A sensor's components side by side (a copy), e.g. `vector("gyro")`.

        Args:
            prefix: What stands before the dot.
            components: those that are wanted, in this order; all by default.

        Raises:
            InputError: A component is missing.
        """
        which = components or VECTORS.get(prefix, ("xyz",))[0]
        return np.column_stack([self.column(f"{prefix}.{k}") for k in which])

    def with_joints_of(self, robot: Robot) -> "Recording":
        """The recording with all joints of a robot.

        A joint that follows another and has no column moves as the robot says, and a
        passive one not at all, until its own equations say more. A motor's current
        becomes the torque at its joint. Joints that the robot lacks, and joints without
        a position, are refused.

        Raises:
            InputError: A column belongs to no joint of the robot, a joint of the robot
                has no position column, or a current no torque constant or a torque
                beside it.
        """
        recorded = self._parts_of("joint", robot, robot.joint_names)
        added = {
            f"joint.{follower}.{what}": factor * self.columns[measured]
            + offset * at_rest
            for follower, leader, factor, offset in robot.couplings
            if follower not in recorded
            for what, at_rest in (("position", 1), ("velocity", 0))
            if (measured := f"joint.{leader}.{what}") in self.columns
        }
        for name in robot.passive:
            own = [f"joint.{name}.{what}" for what in ("position", "velocity")]
            if any(np.nan_to_num(self.columns[x]).any() for x in own if self.has(x)):
                raise InputError(
                    f"{self.source}: joint '{name}' is measured, and the robot file "
                    "has it among its passive joints, which nobody measures; leave out "
                    "one"
                )
            added |= dict.fromkeys(own, np.zeros(self.t.size))
        driven = self._with_torques(robot)
        whole = driven.with_columns(added) if added else driven
        for name in robot.joint_names:
            whole.column(f"joint.{name}.position")
        return whole

    def _with_torques(self, robot: Robot) -> "Recording":
        """The recording with torques, `torque_constant * current`, for currents."""
        columns = dict(self.columns)
        names = [x for x in robot.joint_names if self.has(f"joint.{x}.current")]
        for name in names:
            current, torque = f"joint.{name}.current", f"joint.{name}.torque"
            if self.has(torque):
                raise InputError(
                    f"{self.source}: columns '{current}' and '{torque}' both tell the "
                    "torque at one joint; remove one"
                )
            if name not in robot.torque_constants:
                raise InputError(
                    f"{self.source}: column '{current}': without the motor's torque "
                    "constant it tells no torque; add 'torque_constants: "
                    f"{{{name}: ... N m/A}}' to the robot file, or remove the column"
                )
            columns[torque] = robot.torque_constants[name] * columns.pop(current)
        return replace(self, columns=columns) if names else self

    def check_wheels(self, robot: Robot) -> None:
        """Refuses wheels that the robot lacks, and wheels without a measurement.

        Raises:
            InputError: A column belongs to no wheel of the robot, or a wheel of the
                robot has neither a speed nor a position column.
        """
        self._parts_of("wheel", robot, robot.wheel_names)
        for name in robot.wheel_names:
            if not self.has(f"wheel.{name}.position"):
                self.column(f"wheel.{name}.speed")

    def check_thrusters(self, robot: Robot) -> None:
        """Refuses thrusters that the robot lacks.

        Raises:
            InputError: A column belongs to no thruster of the robot.
        """
        self._parts_of("thruster", robot, [each.name for each in robot.thrusters])

    def check_torquers(self, robot: Robot) -> None:
        """Refuses torquers that the robot lacks.

        Raises:
            InputError: A column belongs to no torquer of the robot.
        """
        self._parts_of("torquer", robot, [each.name for each in robot.torquers])

    def _parts_of(self, kind: str, robot: Robot, names: Sequence[str]) -> set[str]:
        """The robot's parts of this kind that have columns; refuses all others."""
        recorded = {column: part_of(kind, column) for column in self.columns}
        for column, name in recorded.items():
            if name is not None and name not in names:
                raise InputError(
                    f"{self.source}: column '{column}': robot '{robot.name}' has no "
                    f"{kind} '{name}', only {listed(names)}; rename or remove the "
                    "column"
                )
        return {name for name in recorded.values() if name is not None}


def within(
    t: Float[np.ndarray, " samples"], start: float, end: float
) -> Bool[np.ndarray, " samples"]:
    """Which times are from `start` to `end`; what is no number is kept, to be seen."""
    return ~((t < start) | (t > end))


def check_cut(
    source: str, start: float, end: float, rows: int, first: float, last: float
) -> None:
    """Refuse a cut that leaves next to nothing.

    Raises:
        InputError: Fewer than two rows are left.
    """
    if rows < 2:
        begin = f" from {start:g} s" if start > -math.inf else ""
        until = f" to {end:g} s" if end < math.inf else " on"
        raise InputError(
            f"{source}: has {counted(rows, 'row')}{begin}{until}; its times "
            f"are {first:g} s to {last:g} s: choose other ends"
        )
