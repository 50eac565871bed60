"""`orbident simulate ROBOT TRAJ -o REC`."""

from pathlib import Path
from typing import Annotated

import typer

import orbident as oi
from orbident.choices import SensorNoise
from orbident.cli.options import Force, NewRecording, RobotName
from orbident.cli.output import Output, progress
from orbident.files.replacing import check_free


def simulate(
    output: Output,
    robot: RobotName,
    trajectory: Annotated[
        Path,
        typer.Argument(
            metavar="TRAJ",
            help="A trajectory file (YAML); its 'environment' acts on the robot.",
        ),
    ],
    out: NewRecording,
    rate: Annotated[
        float | None,
        typer.Option(help="Samples per second, Hz (default: that of the robot file)."),
    ] = None,
    noise: Annotated[
        SensorNoise,
        typer.Option(
            help="none: ideal sensors for every signal. sensors: those of the robot "
            "file, with their noise."
        ),
    ] = "none",
    seed: Annotated[
        int, typer.Option(help="Random seed of noise and environment.", min=0)
    ] = 0,
    truth: Annotated[
        bool,
        typer.Option(
            "--truth", help="Add noise-free columns, truth.*, to the recording."
        ),
    ] = False,
    force: Force = False,
) -> None:
    """Simulate a free-floating robot on a trajectory, and record it."""
    from orbident.recordings.tables import check_writable
    from orbident.robot.oddities import odd_sensors

    check_writable(out)
    check_free(out, force)
    described = oi.load_robot(robot)
    motion = oi.load_trajectory(trajectory)
    with progress("floating"):
        recording = oi.simulate(
            described, motion, rate=rate, noise=noise, seed=seed, truth=truth
        )
        oi.write_recording(recording, out)
    if noise == "sensors":
        output.warn(odd_sensors(described))
    duration = float(recording.t[-1])
    output.say(
        f"simulated {described.name} along {trajectory}: {recording.t.size} samples "
        f"over {duration:g} s, noise {noise}",
        f"written: {out}",
    )
    output.write_json(
        {
            "recording": str(out),
            "samples": recording.t.size,
            "duration": duration,
            "noise": noise,
            "seed": seed,
        }
    )
