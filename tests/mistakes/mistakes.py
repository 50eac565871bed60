"""All mistakes, by group, and the few that are tried every time."""

from itertools import chain

from flown import of_flown
from mistake import Mistake
from mistakes_in_columns import IN_COLUMNS
from mistakes_in_geometry import IN_GEOMETRY
from mistakes_in_motion import IN_MOTION
from mistakes_in_sensors import IN_SENSORS
from real_effects import EFFECTS

MISTAKES = tuple(
    mistake._replace(group=group)
    for group, members in chain(
        IN_COLUMNS.items(), IN_SENSORS.items(), IN_GEOMETRY.items(), IN_MOTION.items()
    )
    for mistake in members
)

REAL_EFFECTS = tuple(
    effect._replace(group=group, spoil=of_flown(effect.spoil))
    for group, members in EFFECTS.items()
    for effect in members
)
"""What no user did wrong: a table of its own."""

QUICK = (
    "one wheel negated",
    "attitude sensor turned 5 deg",
    "joint2 zero off 20 mrad",
    "wheels lose 1 %, recorded as constant",
)
"""A wrong sign, frame and zero, and what looks like a slow torque; the long test has
all."""


MOST_GROUPS = 3
"""A message that names more kinds of causes is a list of all that can be wrong."""


def names_cause(mistake: Mistake, message: str) -> bool:
    """Whether a message says that it is this, and not that it may be anything."""
    groups = {each.group for each in MISTAKES if each.is_named(message)}
    return mistake.is_named(message) and len(groups) <= MOST_GROUPS


def by_name(name: str) -> Mistake:
    """The one mistake of this name."""
    (mistake,) = (each for each in (*MISTAKES, *REAL_EFFECTS) if each.name == name)
    return mistake
