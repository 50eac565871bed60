"""`orbident check ROBOT`."""

from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import RobotName
from orbident.cli.output import Output


def check(
    output: Output,
    robot: RobotName,
    view: Annotated[
        bool,
        typer.Option("--view", help="Then show it in the browser, as 'view' does."),
    ] = False,
) -> None:
    """Show a robot's tree, masses and sensors, and what looks wrong."""
    from orbident.cli.robot_tree import robot_tree, sensor_lines
    from orbident.cli.view import view as show
    from orbident.environment.worlds import may_act_in_words
    from orbident.robot.oddities import oddities

    described = oi.load_robot(robot)
    odd = (*oddities(described), *_irregular(described), *_hidden(described))
    sensors = list(sensor_lines(described))
    output.say(repr(described), robot_tree(described))
    if sensors:
        output.say("sensors (SI)", *(f"  {line}" for line in sensors))
    output.say(may_act_in_words(described))
    output.say(
        *(["odd", *(f"  {each}" for each in odd)] if odd else ["no problems found"])
    )
    output.write_json(_document(described, odd))
    if view:
        show(Output(None, output.quiet), robot)


def _irregular(robot: Any) -> tuple[str, ...]:
    """Why other verbs refuse the robot."""
    from orbident.model.equations_of_motion import check_regular

    try:
        check_regular(robot)
    except oi.InputError as error:
        return (str(error),)
    return ()


def _hidden(robot: Any) -> tuple[str, ...]:
    """Masses that were measured and help nothing."""
    if not robot.known.bodies:
        return ()
    sets = oi.minimal_sets(robot)
    return tuple(
        f"known: bodies: {name}: no free motion shows this mass alone, so that it "
        "changes no base parameter; the mass of the whole robot would"
        for name in robot.known.bodies
        if sets.of_mass(robot.bodies.index(name)) is None
    )


def _document(robot: Any, odd: tuple[str, ...]) -> dict[str, Any]:
    """Frames as the model has them: the base's at S, any other body's at its joint."""
    from orbident.files.json_parts import nulled

    bodies = [{"name": robot.bodies[0], "theta": robot.theta[0].tolist()}]
    for joint, name, theta in zip(
        robot.joints, robot.bodies[1:], robot.theta[1:], strict=True
    ):
        bodies.append(
            {
                "name": name,
                "parent": robot.bodies[joint.parent],
                "joint": joint.name,
                "type": joint.kind,
                "axis": joint.axis.tolist(),
                "rotation": joint.R_PJ.tolist(),
                "place": joint.p_PJ.tolist(),
                "position": joint.position and list(map(nulled, joint.position)),
                "velocity": joint.velocity,
                "theta": theta.tolist(),
            }
        )
    return {
        "name": robot.name,
        "motion": robot.motion,
        "mass": robot.mass,
        "bodies": bodies,
        "couplings": [coupling._asdict() for coupling in robot.couplings],
        "wheels": list(robot.wheel_names),
        "rotors": {name: rotor._asdict() for name, rotor in robot.rotors.items()},
        "torque_constants": dict(robot.torque_constants),
        "sensors": list(robot.sensors.declared),
        "odd": list(odd),
    }
