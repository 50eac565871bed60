"""`orbident weigh ROBOT REC`."""

from typing import Any

import typer

from orbident.cli.options import Json, Quiet, RecordingFile, RobotName


def weigh(
    robot: RobotName,
    recording: RecordingFile,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Find the total mass from a thruster burn with locked joints.

    This is the paper's Eq. 40. It needs no angular momentum.
    """
    from orbident.cli.output import Output, progress
    from orbident.estimation.weigh import weigh as weighed
    from orbident.recordings.tables import read_recording
    from orbident.robot.robot_file import load_robot

    output = Output(json, quiet)
    described = load_robot(robot)
    table = read_recording(recording)
    with progress("weighing"):
        weighing = weighed(described, table)
    output.warn(weighing.warnings)
    output.say(*_lines(described.name, weighing))
    output.write_json(weighing.to_json())
    if weighing.status == "rejected":
        raise typer.Exit(1)


def _lines(robot: str, weighing: Any) -> list[str]:
    mass = weighing.mass
    found = (
        "mass not determined"
        if weighing.status == "rejected"
        else f"mass {mass.value:.6g} +- {mass.std:.2g} kg"
    )
    impulse = sum(component**2 for component in weighing.impulse) ** 0.5
    return [
        f"{robot}: {weighing.status}, {weighing.samples} samples of {weighing.signal}",
        f"{found}, from an impulse of {impulse:.4g} N s",
    ]
