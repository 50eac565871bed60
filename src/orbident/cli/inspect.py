"""`orbident inspect ROBOT`."""

from math import inf
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.choices import InitialMomentum
from orbident.cli.excite_tables import table_words
from orbident.cli.options import MomentumKnown, RobotName
from orbident.cli.output import Output, progress
from orbident.data_table import Numeric


def inspect(
    output: Output,
    robot: RobotName,
    trajectory: Annotated[
        Path | None,
        typer.Option(
            metavar="TRAJ",
            help="Show for this trajectory the least standard deviations that the "
            "robot's sensors allow (the Cramér-Rao bound).",
        ),
    ] = None,
    initial_momentum: MomentumKnown = "unknown",
    everything: Annotated[
        bool,
        typer.Option("--all", help="Show all parameters, with formulas, pi and phi."),
    ] = False,
) -> None:
    """Show a robot, and what a recording of it can identify."""
    from orbident.cli.identify_tables import budget_lines
    from orbident.estimation.quantities import physical_names
    from orbident.model.equations_of_motion import check_regular
    from orbident.model.formulas import (
        formulas_of,
        nominal_parameters,
        not_identifiable,
    )

    described = oi.load_robot(robot)
    with progress("finding the minimal sets"):
        check_regular(described)
        sets = oi.minimal_sets(described)
        words = formulas_of(described, sets)
        unidentifiable = not_identifiable(described, sets)
        bound = budget = table = None
        if trajectory is not None:
            bound, table = _bound(described, trajectory, initial_momentum)
            budget = bound.budget()
    cad = nominal_parameters(described, sets)
    document: dict[str, Any] = {
        "name": described.name,
        "bodies": list(described.bodies),
        "joints": list(described.joint_names),
        "wheels": list(described.wheel_names),
        "mass": described.mass,
        "count": {name: len(getattr(cad, name)) for name in ("pi", "phi", "base")},
    }
    for name in document["count"]:
        formulas, values = getattr(words, name), getattr(cad, name)
        document[name] = {
            "names": list(formulas.names),
            "formulas": list(formulas.formulas),
            "values": values.tolist(),
        }
        if bound is not None:
            known = getattr(bound.parameters, name)
            std = known.covariance.diagonal() ** 0.5
            pairs = zip(std.tolist(), known.determined, strict=True)
            document[name]["bound"] = [x if sure else None for x, sure in pairs]
    if budget is not None:
        document["budget"] = budget.to_json()
    if table is not None:
        document["table"] = [float(side) if side < inf else None for side in table]
    document["unidentifiable"] = unidentifiable
    document["warnings"] = list(described.warnings)
    lines = _robot(described, document)
    if everything:
        lines += _sets(document)
    else:
        lines += _in_brief(document, physical_names(words.base))
    output.say(*lines, *_open(document), *budget_lines(budget))
    output.write_json(document)


def _bound(robot: Any, trajectory: Path, initial_momentum: InitialMomentum) -> Any:
    """The bound, and the smallest table."""
    from orbident.excitation.bound import bound_of
    from orbident.excitation.guarantee import proven

    motion = oi.load_trajectory(trajectory)
    fires = motion.environment is not None and motion.environment.thrusters
    # What is proven of a floating motion does not hold where thrust acts, or joints
    # swing.
    floats = not fires and not robot.passive
    table = proven(robot, motion.for_robot(robot)).base.table if floats else None
    return bound_of(robot, motion, initial_momentum), table


def _robot(robot: Any, document: dict[str, Any]) -> list[str]:
    """Bodies, joints and wheels, and the table that the motion needs."""
    from orbident.cli.robot_tree import driven_words, wheel_words

    lines = [
        f"{robot.name}: {robot.motion}, {robot.mass:.6g} kg nominal",
        "",
        f"base    {robot.bodies[0]}",
    ]
    for joint, body in zip(robot.joints, robot.bodies[1:], strict=True):
        parent = robot.bodies[joint.parent]
        how = driven_words(robot, joint)
        lines.append(f"joint   {joint.name}: {joint.kind}, {parent} -> {body}{how}")
    lines += [f"wheel   {wheel.name}: {wheel_words(wheel)}" for wheel in robot.wheels]
    if document.get("table"):
        lines.append(f"motion  {table_words(document['table'])}")
    return lines


BOUND = f"{'':8} {'':12} {'bound':>9} {'%':>8}"
"""The head of a parameter's numbers."""

MOST = 24
"""So many parameters are shown unless the user asks for all: with the rest of what is
said of a robot with six joints they fill two screens."""


def _in_brief(document: dict[str, Any], what: list[str]) -> list[str]:
    """The first base parameters, in words, and how many numbers there are."""
    count, entries = document["count"], document["base"]
    head = [f"  {'':25} {BOUND}"] if "bound" in entries else []
    rows = zip(what, _in_words(entries), strict=True)
    lines = [f"  {each:25} {numbers}" for each, numbers in rows]
    more = [f"  and {len(lines) - MOST} more"] if len(lines) > MOST else []
    return [
        "",
        f"{count['base']} base parameters, nominal (M, kg; sigma, kg m; iota, kg m^2),",
        f"from {count['pi']} pi and {count['phi']} phi; --all shows all, with formulas",
        *(*head, *lines[:MOST], *more),
    ]


def _sets(document: dict[str, Any]) -> list[str]:
    """All parameters with their formulas."""
    count, lines = document["count"], []
    titles = {
        "base": f"{count['base']} free-flying base parameters, nominal values: "
        "M, kg; sigma, kg m; iota, kg m^2",
        "phi": f"{count['phi']} phi, m: what the feature point's velocity shows",
        "pi": f"{count['pi']} pi, kg m^2: what the angular momentum shows",
    }
    for name, title in titles.items():
        entries = document[name]
        lines += ["", title]
        if "bound" in entries:
            lines.append(f"  {BOUND}")
        rows = zip(_in_words(entries), entries["formulas"], strict=True)
        lines += [f"  {numbers}   {formula}" for numbers, formula in rows]
    return lines


def _open(document: dict[str, Any]) -> list[str]:
    """What no recording tells, and what is odd about the robot."""
    lines = []
    for title, sentences in (
        ("not identifiable from free floating", document["unidentifiable"]),
        ("warnings", document["warnings"]),
    ):
        if sentences:
            lines += ["", title, *(f"  {sentence}" for sentence in sentences)]
    return lines


def _in_words(entries: dict[str, Any]) -> list[str]:
    """Name and value of each, and its bound, in its unit and in percent of it."""
    pairs = zip(entries["names"], entries["values"], strict=True)
    words = [f"{name:8} {value:12.5g}" for name, value in pairs]
    for k, bound in enumerate(entries.get("bound", ())):
        value = entries["values"][k]
        relative = 100 * bound / abs(value) if value and bound is not None else None
        std, percent = str(Numeric(bound, ".2g")), str(Numeric(relative, ".2g"))
        words[k] += f" {std:>9} {percent:>8}"
    return words
