"""What a load cell shows of a thruster that pulses on a bench.

A pulse lasts from the first row of its command until the first one without. Its thrust
is the median over its second half, less that over the second half of the pause before:
by then valve and cell have settled.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.data_table import DataTable, Numeric, table_of
from orbident.errors import InputError
from orbident.files.names import listed
from orbident.recordings.logs.group import Group
from orbident.recordings.logs.log import is_log, open_log

NEWTON = {
    "N": 1.0,
    "mN": 1e-3,
    "g": 9.80665e-3,
    "gf": 9.80665e-3,
    "kg": 9.80665,
    "kgf": 9.80665,
}
"""What cells count in: grams are those of weights in standard gravity."""

COLUMNS = {
    "time": ("t", "time"),
    "force": ("force", "thrust", "weight", "load"),
    "command": ("command", "duty", "bitmask", "valve"),
}
"""First words of the columns that are read, by what they are."""

FEWEST_PULSES = 3
"""With less there is no scatter to speak of."""

FEWEST_SAMPLES = 8
"""Of a pulse or a pause: of its half a median is taken."""

SETTLED = 0.05
"""Part of the thrust by which the third and the fourth quarter of a pulse differ at
most: a pulse that is still rising has not shown its thrust."""

LOW, HIGH = 0.1, 0.9
"""Parts of the thrust between which rise and decay are measured, as is usual."""


class BenchThrust(NamedTuple):
    """One thruster, over all pulses of a file."""

    name: str
    """Of the file, without its suffix."""
    pulses: int
    thrust: float
    """Median of the pulses, N."""
    scatter: float
    """Standard deviation from pulse to pulse, over the thrust."""
    late: float
    """From the command until a tenth of the thrust, s, median."""
    rise: float
    """From a tenth of the thrust to nine, s, median; the cell's own is in it."""
    decay: float
    """From nine tenths of the thrust to one after the command has ended, s, median."""


def thrust_on_bench(path: Path) -> BenchThrust:
    """Thrust, rise, decay and scatter of one thruster from a load cell's table.

    Args:
        path: a table with the time, what the cell shows with its unit in the column's
            name (`weight_g`, `force [N]`), and the command, zero where it is off.

    Raises:
        InputError: a column is missing or not told apart, several thrusters fire, there
            are fewer than three pulses, or they end before the thrust has settled.
    """
    if path.suffix == ".gz":
        raise InputError(f"{path}: is packed; unpack it, as 'gunzip -k' does")
    if not path.exists() or not is_log(path):
        reason = "is no table" if path.exists() else "does not exist"
        raise InputError(f"{path}: {reason}; give a load cell's recording (CSV)")
    t, force, command = _columns(path)
    fired = sorted({*command[command != 0]})
    if len(fired) > 1:
        raise InputError(
            f"{path}: the command is {fired[0]:g} and {fired[1]:g} as if several "
            "thrusters fired; give a file for each thruster, its command zero or one"
        )
    pulses = list(_pulses(path, t, force, command != 0))
    if len(pulses) < FEWEST_PULSES:
        raise InputError(
            f"{path}: has {len(pulses)} whole pulses, each between two pauses; record "
            f"{FEWEST_PULSES} at least"
        )
    table = np.array(pulses)
    thrust = float(np.median(table[:, 0]))
    late, rise, decay = map(float, np.median(table[:, 1:], axis=0))
    scatter = float(np.std(table[:, 0], ddof=1)) / thrust
    return BenchThrust(path.stem, len(pulses), thrust, scatter, late, rise, decay)


def _columns(path: Path) -> tuple[Float[np.ndarray, " n"], ...]:
    """Time, force in N and command of the rows that have all of them."""
    with open_log(path) as source:
        table = next(iter(source.topics.values()))
        names = {what: _named(table, what, words) for what, words in COLUMNS.items()}
        t, force, command = (
            np.asarray(table.column(name), dtype=np.float64) for name in names.values()
        )
    if not t.size == force.size == command.size:
        raise InputError(f"{path}: its columns are not equally long; make them equal")
    unit = _unit_behind(table, names["force"])
    if unit not in NEWTON:
        raise InputError(
            f"{path}: column '{names['force']}' does not say its unit; give one of "
            f"{', '.join(NEWTON)} in its name, as in weight_g or force_N"
        )
    known = np.isfinite(t) & np.isfinite(force) & np.isfinite(command)
    t, force, command = t[known], force[known] * NEWTON[unit], command[known]
    if t.size < 2 or np.any(np.diff(t) <= 0):
        raise InputError(f"{path}: '{names['time']}' does not grow; give seconds")
    return t, force, command


def _named(table: Group, what: str, words: Sequence[str]) -> str:
    """The one column whose first word is one of these."""
    heads = {name: re.split(r"[^a-z]", name.lower())[0] for name in table.fields}
    found = [name for name, head in heads.items() if head in words]
    if len(found) != 1:
        problem = f"{listed(found)} may each be" if found else "no column is"
        raise InputError(
            f"{table.place}: {problem} the {what}; begin the name of one column with "
            f"{' or '.join(words)}; found {listed(table.fields)}"
        )
    return found[0]


def _unit_behind(table: Group, name: str) -> str:
    """`g` of `weight_g` and `weight [g]`."""
    return re.split(r"[^A-Za-z]+", f"{name} {table.fields[name].unit}".strip(" ])"))[-1]


def _pulses(
    path: Path,
    t: Float[np.ndarray, " n"],
    force: Float[np.ndarray, " n"],
    on: Bool[np.ndarray, " n"],
) -> Iterator[tuple[float, float, float, float]]:
    """Thrust, late, rise and decay of those that have a pause before and behind."""
    edges = np.flatnonzero(np.diff(on)) + 1
    bounds = [0, *edges.tolist(), on.size]
    for k in range(2 if on[0] else 1, len(bounds) - 2, 2):
        before, start, end, after = bounds[k - 1 : k + 3]
        if min(start - before, end - start, after - end) < FEWEST_SAMPLES:
            continue
        zero = float(np.median(force[(before + start) // 2 : start]))
        part = (end - start) // 4
        third, fourth = (
            float(np.median(force[end - k * part : end - (k - 1) * part])) - zero
            for k in (2, 1)
        )
        thrust = float(np.median(force[end - 2 * part : end])) - zero
        if thrust <= 0 or abs(fourth - third) > SETTLED * thrust:
            shown = "no push" if thrust <= 0 else "no settled thrust"
            raise InputError(
                f"{path}: the pulse at {t[start]:g} s has {shown} in its second half; "
                "record longer pulses, pushing the cell so that it counts upwards"
            )
        share = (force - zero) / thrust
        up = [_first(t, share >= level, start, after) for level in (LOW, HIGH)]
        down = [_first(t, share <= level, end, after) for level in (HIGH, LOW)]
        yield thrust, up[0] - float(t[start]), up[1] - up[0], down[1] - down[0]


def _first(
    t: Float[np.ndarray, " n"], reached: Bool[np.ndarray, " n"], start: int, end: int
) -> float:
    """When something is reached first; NaN where it never is."""
    found = np.flatnonzero(reached[start:end])
    return float(t[start + found[0]]) if found.size else float("nan")


def table_of_benches(found: Sequence[BenchThrust]) -> DataTable:
    """A row for each thruster."""
    rows = (
        (
            each.name,
            str(each.pulses),
            Numeric(each.thrust, ".4f"),
            Numeric(100 * each.scatter, ".2f"),
            *(Numeric(value, ".2f") for value in (each.late, each.rise, each.decay)),
        )
        for each in found
    )
    head = ("file", "pulses", "thrust (N)", "scatter (%)")
    return table_of("", (*head, "late (s)", "rise (s)", "decay (s)"), rows)


def thruster_section(found: Sequence[BenchThrust]) -> list[dict[str, Any]]:
    """The `thrusters` section of a robot file, but for where they are.

    A load cell does not know: until it is filled in, the file is refused.
    """
    unsaid = {"position": "x, y, z in m", "direction": "x, y, z of the force"}
    return [
        {"name": each.name, "thrust": round(each.thrust, 4), **unsaid} for each in found
    ]
