"""`orbident new ROBOT.yaml`."""

import os
from pathlib import Path
from typing import Annotated

import typer

import orbident as oi
from orbident.cli.options import Force
from orbident.cli.output import Output
from orbident.files.names import counted
from orbident.files.replacing import check_free, write_text
from orbident.files.text import name_of


def new(
    output: Output,
    robot: Annotated[
        Path, typer.Argument(metavar="FILE", help="The robot file to write (.yaml).")
    ],
    joints: Annotated[
        int | None,
        typer.Option(help="Number of joints of the arm (default: 3).", min=1, max=60),
    ] = None,
    wheels: Annotated[
        int | None,
        typer.Option(help="Number of reaction wheels (default: 3).", min=0, max=60),
    ] = None,
    dh: Annotated[
        bool,
        typer.Option("--dh", help="Describe the arm by a Denavit-Hartenberg table."),
    ] = False,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="The model beside which it stands: URDF, xacro, MJCF, SDF.",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Write a robot file to edit, beside a URDF or without one."""
    from orbident.robot.formats.model_file import KINDS, SUFFIXES
    from orbident.robot.new_robot_file import new_robot_text, robot_text_of_model

    if robot.suffix.lower() not in {".yaml", ".yml"}:
        raise oi.InputError(f"{robot}: give a name that ends in .yaml")
    if model is not None and model.suffix.lower() not in SUFFIXES:
        raise oi.InputError(f"{model}: give {KINDS}")
    own = {"--dh": dh, "--joints": joints is not None, "--wheels": wheels is not None}
    if model is not None and any(own.values()):
        raise oi.InputError(
            f"--model and {next(name for name in own if own[name])} each describe the "
            "robot; give one of them"
        )
    check_free(robot, force)
    if model is None:
        name, taken = name_of(robot.with_suffix("")), ()
        joints, wheels = (3 if n is None else n for n in (joints, wheels))
        text = new_robot_text(name, joints, wheels, table=dh)
    else:
        described = oi.load_robot(model)
        text, taken = robot_text_of_model(
            described, os.path.relpath(model, robot.parent)
        )
        wheels, joints = len(taken), len(described.joints) - len(taken)
    write_text(robot, text)
    named = f" ({', '.join(taken)}, by name)" if taken else ""
    output.say(
        f"{robot}: written, with {counted(joints, 'joint')} and "
        f"{counted(wheels, 'wheel')}{named}; edit its "
        f"numbers, then: orbident check {robot}"
    )
    output.write_json({"robot": str(robot), "joints": joints, "wheels": wheels})
