"""Joints that nobody measures, as a robot file declares them.

They are joints of the model on springs: panels, booms, fuel as a pendulum.
"""

from collections.abc import Collection, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import Name, WrongValueError, keys_of
from orbident.robot.description import Coupling, Joint, Passive, Robot


def _alike(given: object) -> object:
    """Joints that are like another one have its numbers."""
    if not isinstance(given, dict):
        return given
    found = dict[Any, Any](given)
    for name, entry in given.items():
        other = entry.get("like") if isinstance(entry, dict) else None
        if other is None:
            continue
        model = given.get(other)
        if set(entry) - {"like", "inertia"}:
            raise WrongValueError(
                f"{name}: like: {other} gives frequency and damping; leave out the rest"
            )
        if not isinstance(model, dict) or "like" in model or other == name:
            raise WrongValueError(
                f"{name}: like: {quoted(other)}: name another joint beside it, with a "
                "frequency of its own"
            )
        found[name] = model | entry
    return found


PassiveSection = Annotated[
    dict[Name, Annotated[Passive, keys_of(Passive)]], BeforeValidator(_alike)
]
"""As a robot file has it: springs by joint."""


def check_passive(
    passive: Collection[str],
    joints: Sequence[Joint],
    couplings: Sequence[Coupling],
    place: str,
) -> None:
    """Refuse passive joints that a robot does not have, or that do not move freely.

    Args:
        passive: their names.
        joints: of the robot.
        couplings: which of its joints follow others.
        place: the robot file's name, for messages.

    Raises:
        InputError: there is no such joint, or it follows another, or another follows
            it.
    """
    names = [joint.name for joint in joints]
    for name in passive:
        if name not in names:
            raise InputError(
                f"{place}: passive: no joint {name!r}; "
                + suggestion(name, names, "joints")
            )
    for each in couplings:
        for name in {each.follower, each.leader} & {*passive}:
            raise InputError(
                f"{place}: passive.{name}: '{each.follower}' follows '{each.leader}' "
                "in the model, and a passive joint moves by itself; leave out one"
            )


def require_measured(
    robot: Robot, what: str, instead: str = "leave out 'passive'"
) -> None:
    """Refuse a robot with joints that nobody measures.

    Args:
        robot: of any kind.
        what: needs all joints, in words.
        instead: what to do, in words.

    Raises:
        InputError: it has such joints.
    """
    for name in robot.passive:
        raise InputError(
            f"{robot.name}: joint '{name}' is passive, and {what} takes joints that "
            f"are all driven and measured; {instead}"
        )
