"""Joints that nobody measures, as a robot file declares them.

`passive` names joints of the model: panels, booms, fuel as a pendulum. `flexible` puts
one behind a measured joint, about its axis: the encoder is on the motor's side, and
between both is a body without mass.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import Name, WrongValueError, keys_of
from orbident.robot.description import Coupling, Joint, Passive, Robot, Structure
from orbident.robot.fusing import Bodies

BEHIND, BETWEEN = "{}_spring", "{}_motor"
"""Names of the joint behind a flexible one, and of the body before it."""


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


def with_flexible_joints(bodies: Bodies, flexible: Collection[str]) -> Bodies:
    """The bodies with a passive joint behind each of these joints."""
    for name in flexible:
        names = [joint.name for joint in bodies.joints]
        bodies = _with_spring(bodies, names.index(name))
    return bodies


def _with_spring(bodies: Bodies, k: int) -> Bodies:
    joint, body = bodies.joints[k], k + 1

    def moved(other: int) -> int:
        return other + (other >= body)

    behind = Joint(
        name=BEHIND.format(joint.name),
        parent=body,
        kind=joint.kind,
        axis=joint.axis,
        R_PJ=np.eye(3),
        p_PJ=np.zeros(3),
    )
    later = [replace(each, parent=moved(each.parent)) for each in bodies.joints[body:]]
    # What the joint carries begins behind the spring.
    names = [*bodies.names]
    names.insert(body, BETWEEN.format(joint.name))
    return Bodies(
        tuple(names),
        (*bodies.joints[:body], behind, *later),
        np.insert(bodies.theta, body, 0.0, axis=0),
        {
            link: replace(at, body=moved(at.body))
            for link, at in bodies.placements.items()
        },
    )


def passive_joints(
    passive: Mapping[str, Passive],
    flexible: Mapping[str, Passive],
    bodies: Bodies,
    couplings: Sequence[Coupling],
    place: str,
) -> dict[str, Passive]:
    """All passive joints of a robot, by name.

    Args:
        passive: those of the model.
        flexible: joints of the model that have another one behind them.
        bodies: the model.
        couplings: which of its joints follow others.
        place: the robot file's name, for messages.

    Raises:
        InputError: there is no such joint, or it follows another, or another follows
            it, or it is of both kinds.
    """
    names = [joint.name for joint in bodies.joints]
    for section, name in (
        *(("passive", name) for name in passive),
        *(("flexible", name) for name in flexible),
    ):
        if name not in names:
            raise InputError(
                f"{place}: {section}: no joint {name!r}; "
                + suggestion(name, names, "joints")
            )
    for each in couplings:
        for name in {each.follower, each.leader} & {*passive}:
            raise InputError(
                f"{place}: passive.{name}: '{each.follower}' follows '{each.leader}' "
                "in the model, and a passive joint moves by itself; leave out one"
            )
    for name in {*passive} & {*flexible}:
        raise InputError(
            f"{place}: flexible.{name}: the joint is passive: nobody measures it, and "
            "there is nothing behind it; leave out one"
        )
    behind = {
        BEHIND.format(name): each._replace(like=BEHIND.format(each.like))
        if each.like
        else each
        for name, each in flexible.items()
    }
    return {**passive, **behind}


def massless_bodies(flexible: Collection[str]) -> dict[str, Structure]:
    """What is known of the bodies before springs of flexible joints."""
    return {BETWEEN.format(name): Structure(massless=True) for name in flexible}


def require_measured(
    robot: Robot, what: str, instead: str = "leave 'passive' and 'flexible' out"
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
