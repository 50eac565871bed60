"""An entry of a topic map to start from, for a table of a file."""

from collections.abc import Iterable

import yaml

from orbident.recordings.columns import VECTORS, is_known
from orbident.recordings.logs.group import Group, listed_fields

_UNITS = {
    "gyro": "rad/s",
    "accelerometer": "m/s^2",
    "attitude": "quaternion",
    "position": "m",
    "velocity": "m/s",
    "force": "N",
    "torque": "N m",
}
_SHOWN = 100
"""Fields that are listed."""


def proposed_table(group: Group) -> Iterable[str]:
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
        yield "# TODO what is taken, with its unit, and the fields that it is made of:"
        yield "# take: {joint.<name>.position: rad, gyro: deg/s}"
        yield "# fields: {joint.<name>.position: q1, gyro: [wx, -wy, wz]}"
        yield "# frame: base"
    names = [
        f"{name} in {group.unit(name)}" if group.unit(name) else name
        for name in listed_fields(group)
        if name != time
    ]
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    yield "# fields that there are:"
    for start in range(0, min(len(names), _SHOWN), 5):
        part = names[start : min(start + 5, _SHOWN)]
        yield f"#   {', '.join(' '.join(each.split()) for each in part)}"
    if more:
        yield f"#  {more}"
    for name, field in group.fields.items():
        if field.problem:
            yield " ".join(f"# {name} {field.problem}".split())


def _known(group: Group) -> dict[str, tuple[str, str]]:
    """Columns of a recording that stand in the table under their own names."""
    found = {}
    for name, (axes, _) in VECTORS.items():
        parts = [f"{name}.{axis}" for axis in axes]
        if name in _UNITS and all(each in group.fields for each in parts):
            unit = group.unit(parts[0]) or _UNITS[name]
            found[name] = unit, f"[{', '.join(parts)}]"
    for name in group.fields:
        if is_known(name) and name.startswith(("joint.", "wheel.")):
            last = name.rsplit(".", 1)[1]
            unit = "rad" if last == "position" else "rad/s"
            found[name] = group.unit(name) or unit, as_yaml(name)
    return found


def as_yaml(name: str) -> str:
    """A name as YAML writes it, quoted where it must be."""
    listed = yaml.safe_dump([name], default_flow_style=True, allow_unicode=True)
    return listed.strip()[1:-1]
