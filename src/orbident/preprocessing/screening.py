"""A recording without what spoils it: spikes, false rates, angles within a turn."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np
from jaxtyping import Bool, Float
from scipy.integrate import cumulative_trapezoid

from orbident.errors import InputError
from orbident.preprocessing.column_faults import (
    GAP,
    REMEMBERED,
    TURN,
    find_spikes,
    saturated,
    turned_between,
    unwrapped,
    within_a_turn,
)
from orbident.preprocessing.followers import encoders_elsewhere
from orbident.preprocessing.impossible_values import (
    FEWEST,
    MOVED,
    beyond_ranges,
    check_alive,
    check_in_plane,
)
from orbident.preprocessing.rates import coarse_speeds, false_rates
from orbident.preprocessing.smoothing import Settings
from orbident.recordings.column_checks import check_filled
from orbident.recordings.no_measurements import (
    is_position,
    no_measurements,
    reasons_in_words,
    repeats,
    sensor_groups,
    zeros_alone,
)
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

FASTEST = 1000.0
"""rad/s, 9500 turns a minute: no reaction wheel is faster."""

Masks = dict[tuple[str, str], Bool[np.ndarray, " n"]]
"""Which samples are wrong, by column or sensor, and reason."""


@dataclass(frozen=True)
class Screened:
    """A recording without what cannot be true, and what was taken out."""

    recording: Recording
    rejected: Mapping[str, Mapping[str, int]]
    """How many samples were rejected, by column or sensor, and reason."""
    notes: tuple[str, ...] = ()
    """What cannot quite be true, and was left as it is, or put right."""


def screened(robot: Robot, recording: Recording) -> Screened:
    """Refuse what makes a recording useless; take out what spoils it.

    Args:
        robot: with the ranges of its joints.
        recording: of any sensors.

    Raises:
        InputError: a column is empty, a sensor shows one value throughout while joints
            move, a joint's positions are in another unit, or the attitude of a planar
            robot leaves the plane.
    """
    check_filled(recording.source, recording.columns)
    check_alive(robot, recording)
    check_in_plane(robot, recording)
    settings = Settings()
    measured = _measured_only(robot, recording, settings)
    beyond = tuple(beyond_ranges(robot, measured.recording))
    coarse = (
        *coarse_speeds(robot, measured.recording),
        *encoders_elsewhere(robot, measured.recording),
    )
    clean = _put_right(robot, measured, settings)
    return replace(clean, notes=(*beyond, *coarse, *clean.notes))


def cleaned(
    robot: Robot, recording: Recording, settings: Settings, own: slice = np.s_[:]
) -> Screened:
    """As `screened`, and nothing is refused.

    Args:
        robot: whose recording it is.
        recording: of any sensors.
        settings: of the whole recording.
        own: the rows in which samples are counted that are taken out.
    """
    measured = _measured_only(robot, recording, settings, own)
    return _put_right(robot, measured, settings, own)


def rejected_in_words(rejected: Mapping[str, Mapping[str, int]]) -> tuple[str, ...]:
    """What was taken out."""
    return tuple(
        f"{column}: {words} left out"
        for column, reasons in rejected.items()
        for words in reasons_in_words(reasons)
    )


def _measured_only(
    robot: Robot, recording: Recording, settings: Settings, own: slice = np.s_[:]
) -> Screened:
    """Without samples that are no measurement, and with angles that go on."""
    moving = _moving(robot, recording)

    every = [*chain.from_iterable(sensor_groups(recording.columns).values())]
    once = _without(
        recording, own, partial(_of_all, recording), {"rows": every} if every else {}
    )

    def found(sensor: str, names: list[str]) -> Masks:
        table = _table(once.recording, names)
        masks = {(sensor, why): m for why, m in no_measurements(sensor, table).items()}
        if sensor == "gyro":
            for mask in masks.values():
                table[mask] = np.nan
            for name, w in zip(names, table.T, strict=True):
                masks |= {(name, why): m for why, m in saturated(w, moving).items()}
        return masks

    measured = _without(once.recording, own, found)
    turned = _unwrapped(robot, measured.recording, settings)
    notes = [
        f"column '{name}' leaps by a turn: whole turns are added, so that it goes on "
        "as it went before"
        for name in turned
    ]
    return replace(
        measured,
        recording=_changed(measured.recording, turned),
        rejected={**once.rejected, **measured.rejected},
        notes=(*recording.notes, *notes),
    )


def _of_all(recording: Recording, rows: str, names: list[str]) -> Masks:
    """Rows that show nothing new, or nothing at all."""
    columns = [recording.columns[name] for name in names]
    positions = [recording.columns[name] for name in names if is_position(name)]
    found = zeros_alone(columns, positions)
    same = np.ones(recording.t.size - 1, dtype=bool)
    for column in columns:
        same &= np.diff(column) == 0
    # A table of all columns is as large as the recording.
    if same.any():
        table = _table(recording, names)
        for mask in found.values():
            table[mask] = np.nan
        found |= repeats(table)
    return {(rows, why): mask for why, mask in found.items()}


def _moving(robot: Robot, recording: Recording) -> Bool[np.ndarray, " n"]:
    """Where joints are not seen to be just where they were one row before."""
    moving = np.ones(recording.t.size, dtype=bool)
    positions = [f"joint.{name}.position" for name in robot.joint_names]
    seen = [recording.columns[name] for name in positions if recording.has(name)]
    if seen:
        moving[1:] = np.any([q[1:] != q[:-1] for q in seen], axis=0)
    return moving


def _put_right(
    robot: Robot, measured: Screened, settings: Settings, own: slice = np.s_[:]
) -> Screened:
    """Without spikes, and without joint rates that are none."""
    recording, rejected = measured.recording, measured.rejected

    def spikes(_: str, names: list[str]) -> Masks:
        return {(name, "spike"): _spikes(recording, name) for name in names}

    spikeless = _without(recording, own, spikes)
    for column, reasons in spikeless.rejected.items():
        rejected = {**rejected, column: {**rejected.get(column, {}), **reasons}}
    recording = spikeless.recording
    false = settings.once(
        "false rates", lambda: dict(false_rates(recording, robot.joint_names))
    )
    if false:
        columns = {n: x for n, x in recording.columns.items() if n not in false}
        recording = replace(recording, columns=columns)
    notes = [
        f"column '{name}' is not the rate of the joint's position: it {words}; it is "
        "not used"
        for name, words in false.items()
    ]
    return Screened(recording, rejected, (*measured.notes, *notes))


def _without(
    recording: Recording,
    own: slice,
    found: Callable[[str, list[str]], Masks],
    groups: Mapping[str, list[str]] | None = None,
) -> Screened:
    """Without samples that are found in some columns, nor those beside them."""
    spoiled: dict[str, np.ndarray] = {}
    rejected: dict[str, dict[str, int]] = {}
    for sensor, names in (groups or sensor_groups(recording.columns)).items():
        masks = found(sensor, names)
        bad = np.logical_or.reduce([*masks.values()]) if masks else np.array(False)
        for name in names if bad.any() else ():
            spoiled[name] = np.where(bad, np.nan, recording.columns[name])
        for (column, reason), mask in masks.items():
            if count := int(mask[own].sum()):
                rejected.setdefault(column, {})[reason] = count
    return Screened(_changed(recording, spoiled), rejected)


def _table(
    recording: Recording, names: Sequence[str]
) -> Float[np.ndarray, "n columns"]:
    return np.column_stack([recording.columns[name] for name in names])


def _changed(recording: Recording, columns: Mapping[str, np.ndarray]) -> Recording:
    return recording.with_columns(columns) if columns else recording


def _unwrapped(
    robot: Robot, recording: Recording, settings: Settings
) -> dict[str, np.ndarray]:
    """Angles that were shown within one turn, as they go on.

    Raises:
        InputError: a wheel may have turned by any number of turns between samples.
    """
    t, found = recording.t, {}
    ranges = {
        f"joint.{each.name}.position": each.position
        for each in robot.joints
        if each.kind == "revolute"
    }
    for name in (*ranges, *(f"wheel.{name}.position" for name in robot.wheel_names)):
        if not recording.has(name):
            continue
        angle = recording.columns[name]
        if not settings.once(f"turns of {name}", partial(within_a_turn, t, angle)):
            continue
        if name in ranges:
            # A joint goes to and fro, and a wheel on and on.
            steady = GAP * float(np.median(np.diff(t)))
            x = unwrapped(t, angle, TURN, steady)
            between = ranges[name]
            found[name] = turned_between(t, x, between, steady) if between else x
        else:
            found[name] = _turned_on(recording, name)
    return found


def _turned_on(recording: Recording, name: str) -> Float[np.ndarray, " n"]:
    """The angle of a wheel with whole turns added, rad.

    How many turns it makes from one sample to the next, its speed says; or it was at
    rest at first, and has spun up from there; or samples follow too fast for a turn.
    """
    t, angle = recording.t, recording.columns[name]
    speed = name.replace(".position", ".speed")
    if recording.has(speed):
        known = np.flatnonzero(np.isfinite(recording.columns[speed]))
        rate = np.interp(t, t[known], recording.columns[speed][known])
        turned = cumulative_trapezoid(rate, t, initial=0.0)
        return turned + unwrapped(t, angle - turned, TURN, 0.0)
    first = angle[np.isfinite(angle)][:REMEMBERED]
    ambiguous = FASTEST * float(np.median(np.diff(t))) > TURN / 2
    if ambiguous and np.ptp(first) > MOVED:
        raise InputError(
            f"{recording.source}: column '{name}' shows the angle within one turn, and "
            "how many turns the wheel makes between two samples nothing tells; give "
            f"'{speed}' too, or the angle as it goes on"
        )
    return unwrapped(t, angle)


def _spikes(recording: Recording, name: str) -> np.ndarray:
    column = recording.columns[name]
    if np.isfinite(column).sum() < FEWEST:
        return np.zeros(column.size, dtype=bool)
    return find_spikes(recording.t, column, f"{recording.source}: '{name}'").mask
