"""`orbident sample TRAJ -o TABLE --rate HZ`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

import orbident as oi
from orbident.cli.options import Force
from orbident.cli.output import Output
from orbident.files.replacing import check_free


def sample(
    output: Output,
    trajectory: Annotated[
        Path, typer.Argument(metavar="TRAJ", help="A trajectory file (YAML).")
    ],
    out: Annotated[
        Path,
        typer.Option(
            "-o",
            metavar="TABLE",
            help="The table to write, .csv or .parquet; or .yaml with --format.",
        ),
    ],
    rate: Annotated[float, typer.Option(help="Samples per second, Hz.")],
    format_: Annotated[
        Literal["table", "joint-trajectory"],
        typer.Option(
            "--format",
            help="table: CSV or Parquet, by suffix. joint-trajectory: a ROS "
            "trajectory_msgs/JointTrajectory as YAML.",
        ),
    ] = "table",
    force: Force = False,
) -> None:
    """Write a trajectory as samples, for a controller."""
    from orbident.recordings.tables import check_writable
    from orbident.simulation.simulate import (
        motion_table,
        times_to_the_end,
        write_joint_trajectory,
    )

    if format_ == "table":
        check_writable(out)
    check_free(out, force)
    motion = oi.load_trajectory(trajectory)
    t = times_to_the_end(motion, rate)
    if format_ == "table":
        oi.write_recording(motion_table(motion, t), out)
    else:
        write_joint_trajectory(motion, t, out)
    count = t.size
    output.say(
        f"sampled {trajectory}: {count} samples over {motion.duration:g} s, {format_}",
        f"written: {out}",
    )
    output.write_json(
        {
            "table": str(out),
            "format": str(format_),
            "samples": count,
            "duration": motion.duration,
        }
    )
