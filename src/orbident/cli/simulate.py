"""`orbident simulate ROBOT TRAJ -o REC`."""

from pathlib import Path
from typing import Annotated

import typer

from orbident.choices import SensorNoise
from orbident.cli.options import Force, Json, NewRecording, Quiet, RobotName


def simulate(
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
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Simulate a free-floating robot on a trajectory, and record it."""
    from orbident.cli.output import Output, progress
    from orbident.files.replacing import check_free
    from orbident.recordings.tables import check_writable, write_recording
    from orbident.robot.oddities import odd_sensors
    from orbident.robot.robot_file import load_robot
    from orbident.simulation.simulate import simulate as simulated
    from orbident.trajectories.trajectory_file import load_trajectory

    output = Output(json, quiet)
    check_writable(out)
    check_free(out, force)
    described = load_robot(robot)
    motion = load_trajectory(trajectory)
    with progress("floating"):
        recording = simulated(
            described, motion, rate=rate, noise=noise, seed=seed, truth=truth
        )
        write_recording(recording, out)
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
