"""`orbident inspect ROBOT`."""

from typing import Any

from orbident.cli.options import Json, Quiet, RobotName


def inspect(robot: RobotName, json: Json = None, quiet: Quiet = False) -> None:
    """What a robot has, and what a recording of it can identify."""
    from orbident.cli.output import Output, prepare_jax, progress
    from orbident.dynamics.regularity import check_regular
    from orbident.regressors.formulas import formulas_of
    from orbident.regressors.identifiability import not_identifiable
    from orbident.regressors.minimal_sets import minimal_sets
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    described = load_robot(robot)
    prepare_jax()
    with progress("finding the minimal sets"):
        check_regular(described)
        sets = minimal_sets(described)
        words = formulas_of(described, sets)
        unidentifiable = not_identifiable(described, sets)
    theta = described.theta
    found = {
        "pi": (words.pi, sets.pi(theta)),
        "phi": (words.phi, sets.phi(theta)),
        "base": (words.base, sets.beta(theta)),
    }
    document: dict[str, Any] = {
        "name": described.name,
        "bodies": list(described.bodies),
        "joints": list(described.joint_names),
        "wheels": list(described.wheel_names),
        "mass": described.mass,
        "count": {name: len(values) for name, (_, values) in found.items()},
    }
    for name, (formulas, values) in found.items():
        document[name] = {
            "names": list(formulas.names),
            "formulas": list(formulas.formulas),
            "values": values.tolist(),
        }
    document["unidentifiable"] = unidentifiable
    document["warnings"] = list(described.warnings)
    output.say(*_lines(described, document))
    output.write_json(document)


def _lines(robot: Any, document: dict[str, Any]) -> list[str]:
    count = document["count"]
    lines = [
        f"{robot.name}: {robot.motion}, {robot.mass:.6g} kg nominal",
        "",
        f"base    {robot.bodies[0]}",
    ]
    for joint, body in zip(robot.joints, robot.bodies[1:], strict=True):
        parent = robot.bodies[joint.parent]
        lines.append(f"joint   {joint.name}: {joint.kind}, {parent} -> {body}")
    for wheel in robot.wheels:
        axis = ", ".join(f"{component:.4g}" for component in wheel.axis)
        lines.append(
            f"wheel   {wheel.name}: {wheel.inertia:.4g} kg m^2 about [{axis}], "
            f"{wheel.mode}"
        )
    titles = {
        "base": f"{count['base']} free-flying base parameters, nominal values: "
        "M, kg; sigma, kg m; iota, kg m^2",
        "phi": f"{count['phi']} phi, m: what the feature point's velocity shows",
        "pi": f"{count['pi']} pi, kg m^2: what the angular momentum shows",
    }
    for name, title in titles.items():
        entries = document[name]
        lines += ["", title]
        rows = zip(
            entries["names"], entries["values"], entries["formulas"], strict=True
        )
        lines += [f"  {n:8} {value:12.5g}   {formula}" for n, value, formula in rows]
    for title, sentences in (
        ("not identifiable from free floating", document["unidentifiable"]),
        ("warnings", document["warnings"]),
    ):
        if sentences:
            lines += ["", title, *(f"  {sentence}" for sentence in sentences)]
    return lines
