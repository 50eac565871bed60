"""`orbident weigh ROBOT REC`, and of thrusters on a bench."""

from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.output import Output, progress
from orbident.errors import InputError


def weigh(
    output: Output,
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="ROBOT REC",
            help="A robot (a bundled name, a robot file or a model) and a recording of "
            "a burn (CSV or Parquet). With --bench: FILE..., a load cell's recording "
            "of each thruster.",
        ),
    ],
    bench: Annotated[
        bool,
        typer.Option(
            "--bench",
            help="Find the thrust of thrusters from pulses on a load cell, and print "
            "the 'thrusters' section of a robot file.",
        ),
    ] = False,
) -> None:
    """Find the total mass from a thruster burn with locked joints.

    This is the paper's Eq. 40. It needs no angular momentum.
    """
    if bench:
        _on_bench(output, files)
        return
    if len(files) != 2:
        raise InputError(
            f"found {len(files)} of ROBOT and REC; give a robot and one recording, or "
            "--bench before the recordings of a load cell"
        )
    robot, recording = files
    described = oi.load_robot(robot)
    table = oi.read_recording(recording)
    with progress("weighing"):
        weighing = oi.weigh(described, table)
    output.warn(weighing.warnings)
    output.say(*_lines(described.name, weighing))
    output.write_json(weighing.to_json())
    if weighing.status == "rejected":
        raise typer.Exit(1)


def _on_bench(output: Output, files: list[str]) -> None:
    import yaml

    from orbident.noise.thrust_bench import (
        table_of_benches,
        thrust_on_bench,
        thruster_section,
    )

    found = [thrust_on_bench(Path(file)) for file in files]
    section = thruster_section(found)
    output.say(
        table_of_benches(found),
        "",
        "rise and decay hold the load cell's own; scatter is from pulse to pulse",
        "",
        yaml.safe_dump(
            {"thrusters": section}, sort_keys=False, default_flow_style=None, width=1000
        ).rstrip(),
    )
    measured = {each.name: each._asdict() for each in found}
    output.write_json({"bench": measured, "thrusters": section})


def _lines(robot: str, weighing: Any) -> list[str]:
    mass = weighing.mass
    verdict, found = "trusted", f"mass {mass.value:.6g} +- {mass.std:.2g} kg"
    if weighing.status == "rejected":
        verdict, found = "refused", "mass not determined"
    impulse = sum(component**2 for component in weighing.impulse) ** 0.5
    lines = [
        f"{robot}: {verdict}, {weighing.samples} samples of {weighing.signal}",
        f"{found}, from an impulse of {impulse:.4g} N s",
    ]
    thrust = weighing.thrust
    if thrust.value == thrust.value:
        lines.append(
            f"by the mass of 'known', thrust is {thrust.value:.4g} +- {thrust.std:.2g} "
            "of what was recorded"
        )
    return lines
