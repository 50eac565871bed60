"""How large what acts on a robot from outside may be, as robot files write it."""

import math
from typing import Any, NamedTuple

from orbident.choices import DisturbanceGroup
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import WrongValueError
from orbident.robot.units import at_least_zero

DIMENSIONS = {
    DisturbanceGroup.torque: "torque",
    DisturbanceGroup.slow_torque: "torque",
    DisturbanceGroup.base_torque: "torque",
    DisturbanceGroup.slow_base_torque: "torque",
    DisturbanceGroup.wheel_loss: "torque",
    DisturbanceGroup.leak: "force",
    DisturbanceGroup.pull: "acceleration or slope",
    DisturbanceGroup.uneven: "slope",
    DisturbanceGroup.drag: "drag",
    DisturbanceGroup.hose: "stiffness",
    DisturbanceGroup.air: "force",
    DisturbanceGroup.sunlight: "force",
    DisturbanceGroup.dipole: "magnetic moment",
}
"""The dimension of each size; a walk has its density under `momentum_walk`, and what
is on springs is better declared as passive joints."""

FREE = "free"
"""In place of a size: it may be as large as it wants to."""


class MayAct(NamedTuple):
    """How large something from outside may be."""

    size: float
    """Standard deviation of it beforehand, SI; infinite where it may be anything."""
    shortest: float | None = None
    """s: what changes slowly takes at least as long to swing from one side to the
    other and back; None where the world says it."""


def may_act(given: object) -> dict[str, MayAct] | None:
    """What a robot file says of what may act; None where it says nothing.

    Given are names of groups that act, of any size, or sizes by the groups' names.

    Raises:
        WrongValueError: there is no such group, or a size is no size of it.
    """
    if given is None:
        return None
    if isinstance(given, list | tuple):
        return {_group(name): MayAct(math.inf) for name in given}
    if not isinstance(given, dict):
        raise WrongValueError(
            "give a list of what acts, such as [pull, drag], or sizes, such as "
            "{slow_torque: 3 mN m}"
        )
    return {_group(name): _size(_group(name), value) for name, value in given.items()}


def _group(name: object) -> str:
    groups = [*map(str, DisturbanceGroup)]
    if name not in groups:
        words = suggestion(str(name), groups, "names")
        raise WrongValueError(f"{quoted(name)} is unknown; {words}")
    return str(name)


def _size(group: str, given: object) -> MayAct:
    keys: dict[Any, Any] = given if isinstance(given, dict) else {"size": given}
    if not {"size"} <= keys.keys() <= {"size", "shortest"}:
        raise WrongValueError(f"{group}: give a size, or size and shortest")
    try:
        size = _read(keys["size"], DIMENSIONS.get(DisturbanceGroup(group)))
        shortest = at_least_zero(keys.get("shortest", 0.0), "time") or None
    except WrongValueError as error:
        raise WrongValueError(f"{group}: {error}") from None
    return MayAct(size, shortest)


def _read(size: object, dimension: str | None) -> float:
    if size in (FREE, math.inf):
        return math.inf
    if dimension is None:
        raise WrongValueError(
            f"give '{FREE}', or its density under momentum_walk, or its springs under "
            "passive"
        )
    return at_least_zero(size, dimension)
