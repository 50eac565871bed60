"""Topic maps: what each topic feeds, in which unit and frame; nothing is guessed.

In one to start from, what only a person knows is left open. Units are those of REP 103,
SI, stated so that they can be checked. What no message tells (frames, directions, which
number feeds what) is missing, so the map does not load until it is filled in.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from pydantic import Field

from orbident.errors import InputError
from orbident.files.names import joined, suggestion
from orbident.files.schema_parts import (
    MappingSchema,
    line_of,
    read_yaml_mapping,
    validated,
)
from orbident.files.text import read_text
from orbident.recordings.columns import VECTORS, is_known, vector_columns
from orbident.recordings.logs.group import Group
from orbident.recordings.topics.any_message import Message
from orbident.recordings.topics.entry import Entry
from orbident.recordings.topics.fields import Table, missing_of
from orbident.recordings.topics.messages import MESSAGE_TYPES, PATHS
from orbident.recordings.topics.presets import preset_path, preset_topics, presets
from orbident.recordings.topics.survey import LISTED, Surveyed
from orbident.recordings.topics.targets import DIMENSION_OF, DIMENSIONS, dimension_of
from orbident.robot.description import Robot

SCHEMA = "orbident/topic-map/1"

TYPES: Mapping[str, type[Entry]] = {**MESSAGE_TYPES, "table": Table}
"""The messages that can be mapped, and the tables of files that hold no messages."""


class _TopicMap(MappingSchema):
    schema_: Literal["orbident/topic-map/1"] = Field(alias="schema")
    topics: tuple[dict[str, Any], ...] = Field(min_length=1)


def load_topic_map(path: str | Path, place: str | None = None) -> tuple[Entry, ...]:
    """Reads a topic map.

    In messages it is called `place`; by default that is its path.

    Raises:
        InputError: The file is missing, not YAML or of another schema; an entry has an
            unknown type or key, lacks a unit or a frame; or two feed one column.
    """
    place = place or str(path)
    text = read_text(Path(path))
    file = validated(_TopicMap, read_yaml_mapping(text, place, SCHEMA), place, text)
    entries = [_entry(each, place, text, k) for k, each in enumerate(file.topics)]
    fed: dict[str, str] = {}
    for number, entry in enumerate(entries):
        for column in entry.columns:
            if column in fed:
                line = line_of(text, ("topics", number))
                raise InputError(
                    f"{place}{line}: column '{column}' is fed twice, by "
                    f"'{fed[column]}' and '{entry.topic}'; keep one"
                )
            fed[column] = entry.topic
    return tuple(entries)


def _entry(document: dict[str, Any], place: str, text: str, number: int) -> Entry:
    within = ("topics", number)
    at = f"{place}{line_of(text, (*within, 'type'))}: topics[{number}].type"
    if "type" not in document:
        raise InputError(
            f"{at}: this key is missing; add it, 'orbident topics' shows it"
        )
    kind = str(document["type"]).replace("/msg/", "/")
    if kind != "table" and "fields" in document:
        entry = Message
    elif kind in TYPES:
        entry = TYPES[kind]
    else:
        known = suggestion(kind, TYPES, "types")
        raise InputError(f"{at}: '{kind}' cannot be mapped without 'fields'; {known}")
    return validated(entry, {**document, "type": kind}, place, text, within)


_UNITS = {name: next(iter(DIMENSIONS[of])) for name, of in DIMENSION_OF.items()}
_UNITS["attitude"] = "quaternion"


def _proposed_table(
    found: Surveyed, group: Group, robot: Robot | None
) -> Iterable[str]:
    """Lines of YAML: the time, what has a column's name already, and the fields."""
    time = group.time
    if time is None:
        yield "# TODO stamp: {<the field that holds the time>: s}, or ms, us, ns"
    else:
        unit = group.unit(time) or "s"
        yield f"stamp: {{{as_yaml(time)}: {unit}}}  # check the unit: s, ms, us or ns"
    known = _known(group)
    if known:
        yield "take:  # SI where the file tells no unit; check the units"
        yield from (f"  {as_yaml(name)}: {unit}" for name, (unit, _) in known.items())
        yield "fields:"
        yield from (f"  {as_yaml(name)}: {what}" for name, (_, what) in known.items())
        if any(name in VECTORS for name in known):
            yield "frame: base  # check; else 'rotation: [x, y, z, w]' to the base's"
            yield "point: S  # check that the feature point is what is measured"
    else:
        yield from _to_fill(robot)
    seen = (
        _seen_field(found, name, group.unit(name), words)
        for name, words in zip(group.usable, found.labels, strict=True)
        if name != time
    )
    yield from _listing(seen)
    for name, field in group.fields.items():
        if field.problem:
            # What to do about it is for those who want to take it.
            problem, _, _ = field.problem.partition(";")
            yield " ".join(f"# {name} {problem}".split())


def _to_fill(robot: Robot | None) -> Iterable[str]:
    yield "# TODO what is taken, with its unit, and the fields that it is made of:"
    yield "# take: {joint.<name>.position: rad, gyro: deg/s}"
    yield "# fields: {joint.<name>.position: q1, gyro: [wx, -wy, wz]}"
    yield "# frame: base"
    if robot is not None:
        yield _names_of(robot)


def _names_of(robot: Robot) -> str:
    joints, wheels = joined(robot.joint_names), joined(robot.wheel_names)
    return " ".join(f"# {robot.name} has joints {joints}; wheels {wheels}".split())


def _listing(seen: Iterable[str]) -> Iterable[str]:
    seen = tuple(seen)
    yield "# fields that there are:"
    yield from (f"#   {' '.join(each.split())}" for each in seen[:LISTED])
    if len(seen) > LISTED:
        yield f"#   and {len(seen) - LISTED} more"


def _seen_field(found: Surveyed, name: str, unit: str, words: str) -> str:
    """A field of a table, its unit if the file tells one, and its range."""
    if unit:
        words += f" in {unit}"
    if name not in found.ranges:
        return words
    # A wheel turns on and on.
    silent = unit or name.startswith("wheel.")
    return words + _seen(found.ranges[name], "" if silent else dimension_of(name))


def _any_message(found: Surveyed, robot: Robot | None) -> Iterable[str]:
    if found.offset is None:
        yield "# TODO stamp: {<the field that holds the time>: us}, if there is one"
    yield from _to_fill(robot)
    yield from _listing(f"{path}{_seen(x, '')}" for path, x in found.ranges.items())


_RATHER: Mapping[str, tuple[float, float, str]] = {
    "angle": (2 * math.pi, 1e5, "deg"),
    "angular rate": (math.pi, 400.0, "deg/s"),
    "length": (100.0, 1e5, "mm"),
    "velocity": (10.0, 1e3, "mm/s"),
    "acceleration": (0.9, 1.1, "g"),
}
"""Between these, the largest value in a laboratory is rather in this unit than in SI:
joints turn at most once, a base not in two seconds, tables are below 100 m and crossed
slower than 10 m/s, and at rest an accelerometer shows 1 g."""


def _seen(values: tuple[float, float], dimension: str) -> str:
    """The range of values, and the unit that it suggests."""
    low, high = values
    least, most, unit = _RATHER.get(dimension, (0.0, 0.0, ""))
    rather = f" ({unit}?)" if least < max(-low, high) < most else ""
    return f" {low:.4g} to {high:.4g}{rather}"


def _seen_of(found: Surveyed, name: str, path: str) -> str:
    """A vector's range, of all its axes."""
    some = [x for key, x in found.ranges.items() if f".{path}." in f".{key}"]
    low, high = np.array(some).T
    seen = float(np.fmin.reduce(low)), float(np.fmax.reduce(high))
    return f"#   {name}{_seen(seen, DIMENSION_OF.get(name, ''))}"


def _known(group: Group) -> dict[str, tuple[str, str]]:
    """Columns of a recording that stand in the table under their own names."""
    found = {}
    for name in VECTORS:
        parts = vector_columns(name)
        if name in _UNITS and all(each in group.fields for each in parts):
            unit = group.unit(parts[0]) or _UNITS[name]
            found[name] = unit, f"[{', '.join(parts)}]"
    for name in group.fields:
        if is_known(name) and name.startswith(("joint.", "wheel.")):
            si = next(iter(DIMENSIONS[dimension_of(name)]))
            found[name] = group.unit(name) or si, as_yaml(name)
    return found


def as_yaml(name: str) -> str:
    """A name as YAML writes it, quoted where it must be."""
    listed = yaml.safe_dump([name], default_flow_style=True, allow_unicode=True)
    return listed.strip()[1:-1]


_SI = "# REP 103 says SI; check that the sender keeps to it"
_FRAME = (
    "# TODO 'frame: base' if its axes are the base's, else 'rotation: [x, y, z, w]',",
    "#      which turns vectors from its axes to the base's",
)
_POINT = (
    "# TODO 'point: S' if {what} the robot's feature_point;",
    "#      else move feature_point there, or take less",
)


def proposed_map(surveyed: Sequence[Surveyed], robot: Robot | None = None) -> str:
    """The YAML text of a topic map; a person completes it at each TODO.

    The robot's joints and wheels may have the names that are in the messages.
    """
    lines = [
        "# Proposed by 'orbident topics'. Decide at every TODO; delete the topics that",
        "# are not needed. Two topics cannot feed one column: keep the better one.",
        *(
            f"# '--preset {name}' maps topics of this file; it may do instead."
            for name in presets()
            if _fits(name, surveyed)
        ),
        f"schema: {SCHEMA}",
        "topics:",
    ]
    for each in surveyed:
        topic, propose = each.topic, _PROPOSALS.get(each.topic.type, _any_message)
        if not topic.count:
            lines.append(f"  # {topic.name} ({topic.type}) has nothing to take")
            continue
        if isinstance(topic, Group):
            body = ["type: table", *_proposed_table(each, topic, robot)]
        elif each.ranges:
            body = [f"type: {topic.type}", *propose(each, robot)]
        else:
            lines.append(f"  # {topic.name} ({topic.type}) cannot be mapped: it has no")
            lines.append("  #   numbers, or the file has no definition of it")
            continue
        lines.append(f"  - topic: {as_yaml(topic.name)}")
        lines += [f"    {line}" for line in body]
    return "\n".join(lines) + "\n"


def _fits(name: str, surveyed: Sequence[Surveyed]) -> bool:
    """Whether a preset maps at least two of the topics, or the only one."""
    topics = {each.topic.name: each.topic for each in surveyed}
    wanted = min(2, len(topics))
    if len(preset_topics(name).intersection(topics)) < wanted:
        return False
    entries = load_topic_map(preset_path(name))
    found = {each.topic for each in entries if not missing_of(each, topics)}
    return len(found) >= wanted


def _joint_states(found: Surveyed, robot: Robot | None) -> Iterable[str]:
    units = {"position": "rad", "velocity": "rad/s"}
    given = {key: u for key, u in units.items() if len(getattr(found.example, key))}
    yield _take(given or units)
    yield "# TODO prismatic joints (m, m/s) need an entry of their own"
    wheels = set(robot.wheel_names) if robot else set()
    joints = set(robot.joint_names) if robot else set(found.labels)
    for key, known in (("joints", joints), ("wheels", wheels)):
        named = [name for name in found.labels if name in known]
        if named:
            yield f"{key}:  # name in the messages: name in the robot"
        for name in named:
            yield f"  {as_yaml(name)}: {as_yaml(name)}{_seen_of_joint(found, name)}"
    if robot is None:
        yield "# TODO move reaction wheels to"
        yield "# wheels: {name in the messages: name in the robot}"
        return
    for name in found.labels:
        if name not in joints | wheels:
            key = f"{{{as_yaml(name)}: <the robot's name>}}"
            yield f"# TODO joints or wheels: {key}{_seen_of_joint(found, name)}"
    yield _names_of(robot)


def _seen_of_joint(found: Surveyed, name: str) -> str:
    dimensions = {"position": "angle", "velocity": "angular rate", "effort": ""}
    seen = [
        f"{key}{_seen(found.ranges[path], dimension)}"
        for key, dimension in dimensions.items()
        if (path := f"{key}.{name}") in found.ranges
    ]
    return f"  # {', '.join(seen)}" if seen else ""


def _vectors(found: Surveyed, _: Robot | None) -> Iterable[str]:
    kind, taken, said = found.topic.type, {}, []
    for name in PATHS[kind]:
        x = getattr(found.example, "orientation", None)
        if name == "attitude" and x is not None and not any((x.x, x.y, x.z, x.w)):
            said = ["# its orientation is all zero, so attitude is left out"]
        else:
            taken[name] = _UNITS[name]
    yield _take(taken)
    yield from (_seen_of(found, name, PATHS[kind][name]) for name in taken)
    yield from said
    if kind == "nav_msgs/Odometry":
        yield "# TODO twist: child (as the message is defined), or parent"
    elif "pose" in MESSAGE_TYPES[kind].model_fields:
        yield "# TODO pose: base-in-inertial, or inertial-in-base"
    yield from _FRAME
    yield from (line.format(what=_AT_S[kind]) for line in _POINT)


def _transform(found: Surveyed, robot: Robot | None) -> Iterable[str]:
    pairs = [label.split(" -> ") for label in found.labels]
    if len(pairs) == 1:
        yield f"parent: {as_yaml(pairs[0][0])}"
        yield f"child: {as_yaml(pairs[0][1])}"
    else:
        yield "# TODO parent and child, one of"
        for parent, child in pairs:
            yield f"# parent: {as_yaml(parent)}, child: {as_yaml(child)}"
    yield from _vectors(found, robot)


def _float64(found: Surveyed, _: Robot | None) -> Iterable[str]:
    yield f"#   data{_seen(found.ranges['data'], '')}"
    yield "# TODO take: {wheel.<name>.speed: rad/s}, or another column, and its unit"


_TRACKED = "the body that is tracked has its origin at"
_AT_S = {
    **dict.fromkeys(PATHS, _TRACKED),
    "sensor_msgs/Imu": "the accelerometer is at",
    "nav_msgs/Odometry": "the child frame has its origin at",
    "geometry_msgs/WrenchStamped": "the torque is about",
}
"""What of a message may be the feature point."""

_PROPOSALS: Mapping[str, Callable[[Surveyed, Robot | None], Iterable[str]]] = {
    **dict.fromkeys(PATHS, _vectors),
    "sensor_msgs/JointState": _joint_states,
    "geometry_msgs/TransformStamped": _transform,
    "tf2_msgs/TFMessage": _transform,
    "std_msgs/Float64": _float64,
}


def _take(units: Mapping[str, str]) -> str:
    listed = ", ".join(f"{key}: {name}" for key, name in units.items())
    return f"take: {{{listed}}}  {_SI}"
