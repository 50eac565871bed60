"""`orbident new ROBOT.yaml`."""

from pathlib import Path
from typing import Annotated

import typer

import orbident as oi
from orbident.cli.options import Force
from orbident.cli.output import Output


def new(
    output: Output,
    robot: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="The robot file to write (.yaml)."),
    ],
    joints: Annotated[
        int, typer.Option(help="Number of joints of the arm.", min=1, max=60)
    ] = 3,
    wheels: Annotated[
        int, typer.Option(help="Number of reaction wheels.", min=0, max=60)
    ] = 3,
    dh: Annotated[
        bool,
        typer.Option("--dh", help="Describe the arm by a Denavit-Hartenberg table."),
    ] = False,
    force: Force = False,
) -> None:
    """Write a robot file to edit, for a robot without a URDF."""
    from orbident.files.replacing import check_free
    from orbident.files.text import name_of, write_text
    from orbident.robot.new_robot_file import new_robot_text

    if robot.suffix.lower() not in {".yaml", ".yml"}:
        raise oi.InputError(f"{robot}: give a name that ends in .yaml")
    check_free(robot, force)
    name = name_of(robot.with_suffix(""))
    write_text(robot, new_robot_text(name, joints, wheels, table=dh))
    output.say(
        f"{robot}: written, with {joints} joints and {wheels} wheels; edit its "
        f"numbers, then: orbident check {robot}"
    )
    output.write_json({"robot": str(robot), "joints": joints, "wheels": wheels})
