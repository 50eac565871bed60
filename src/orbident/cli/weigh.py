"""`orbident weigh ROBOT REC`."""

from typing import Any

import typer

import orbident as oi
from orbident.cli.options import RecordingFile, RobotName
from orbident.cli.output import Output, progress


def weigh(output: Output, robot: RobotName, recording: RecordingFile) -> None:
    """Find the total mass from a thruster burn with locked joints.

    This is the paper's Eq. 40. It needs no angular momentum.
    """
    described = oi.load_robot(robot)
    table = oi.read_recording(recording)
    with progress("weighing"):
        weighing = oi.weigh(described, table)
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
