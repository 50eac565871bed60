"""The motors' rotors of a robot file, joint by joint, and what a model says of them."""

import json
import math
from collections.abc import Collection, Mapping, Sequence
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.schema_parts import Name, keys_of
from orbident.robot.description import NO_ROTOR, GearedRotor, Joint, Structure
from orbident.robot.tolerance_schema import EVERY
from orbident.robot.urdf import Urdf

NONE = "none"
"""In place of a rotor, or of all: the joint's motor has no gear."""

ALONG = 1e-6
"""How far from an axis of a body a unit vector may be: files print few digits."""


def _or_none(given: object) -> object:
    return NO_ROTOR._asdict() if given == NONE else given


RotorEntry = Annotated[GearedRotor, keys_of(GearedRotor), BeforeValidator(_or_none)]
RotorSection = Annotated[
    dict[Name, RotorEntry],
    BeforeValidator(lambda given: {EVERY: NONE} if given == NONE else given),
]
"""As a robot file has it: rotors by joint, or `none`."""


def rotors_by_joint(
    given: Mapping[str, GearedRotor],
    joints: Sequence[Joint],
    bodies: Sequence[str],
    structure: Mapping[str, Structure],
    place: str,
) -> dict[str, GearedRotor]:
    """The rotors of a robot's joints, all of them where the file says `none`.

    Raises:
        InputError: there is no such joint, it slides, or a rotor has another axis than
            those of a body whose products of inertia are known to be zero.
    """
    if given == {EVERY: NO_ROTOR}:
        return dict.fromkeys([joint.name for joint in joints], NO_ROTOR)
    at = {joint.name: k for k, joint in enumerate(joints)}
    for name, rotor in given.items():
        if name not in at:
            raise InputError(
                f"{place}: rotors: no joint {name!r}; {suggestion(name, at, 'joints')}"
            )
        joint = joints[at[name]]
        if joint.kind == "prismatic" and rotor != NO_ROTOR:
            raise InputError(
                f"{place}: rotors.{name}: the joint slides, and only rotors that turn "
                "with a joint that turns are known here; leave it out"
            )
        axes = {at[name] + 1: joint.axis, joint.parent: joint.R_PJ @ joint.axis}
        for body, a in axes.items():
            known = structure.get(bodies[body], Structure()).principal_axes
            if known and rotor != NO_ROTOR and np.abs(a).max() < 1 - ALONG:
                raise InputError(
                    f"{place}: rotors.{name}: its axis is none of '{bodies[body]}', so "
                    f"that momentum shows products of inertia: leave principal_axes "
                    f"out of structure.{bodies[body]}"
                )
    return dict(given)


def armature_stds(
    rotors: Mapping[str, GearedRotor], joints: Sequence[Joint]
) -> dict[str, float]:
    """Standard deviations of `N (N - 1) J` by joint, kg m^2 or kg.

    They are infinite where nothing is said of a joint's motor.
    """
    said = {joint.name: rotors.get(joint.name) for joint in joints}
    return {
        name: math.inf
        if rotor is None
        else abs(rotor.gear * (rotor.gear - 1)) * rotor.inertia * rotor.tolerance
        for name, rotor in said.items()
    }


def proposed_rotors(
    urdf: Urdf, joints: Sequence[Joint], said: Collection[str]
) -> list[str]:
    """What to say of the rotors that a model knows of, in words.

    Args:
        urdf: whose joints have gears and armatures.
        joints: those that move.
        said: joints of which the robot file says it already.
    """
    turning = {j.name for j in joints if j.kind == "revolute"} - set(said)
    words = []
    for joint in urdf.joints:
        gear, armature = joint.gear, joint.armature
        if joint.name not in turning or (gear is None and not armature):
            continue
        ratio = "?" if gear is None else f"{gear:.6g}"
        inertia = f"{armature / gear**2:.4g}" if gear and armature else "?"
        if armature and gear is None:
            inertia = f"{armature:.4g} / gear^2"
        # Quoted where YAML would read something else.
        name = joint.name if joint.name.isidentifier() else json.dumps(joint.name)
        words.append(f"{name}: {{gear: {ratio}, inertia: {inertia}}}")
    if not words:
        return []
    return [
        "the model has motors with gears or armatures, of which momentum shows a part: "
        f"give rotors: {{{', '.join(words)}}} in a robot file, or rotors: none"
    ]
