"""Arguments and options that several verbs share."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A bundled name, a robot file, or a URDF, xacro, MJCF or SDF file.",
    ),
]
Json = Annotated[
    str | None,
    typer.Option("--json", metavar="FILE|-", help="Write the result there as JSON."),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print warnings only.")]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        min=1,
        help="Processes on this machine; by default the processors at hand.",
    ),
]
RecordingFile = Annotated[
    Path, typer.Argument(metavar="REC", help="A recording: CSV or Parquet.")
]
LogFile = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="A ROS bag (of ROS 2 its folder), or a file of MCAP, MATLAB, HDF5, PX4 "
        "ULog, NumPy (.npz), Parquet or CSV.",
    ),
]
Preset = Annotated[
    str | None,
    typer.Option(
        "--preset",
        metavar="NAME",
        help="A map that comes with Orbident: astrobee, basilisk, cepheus, "
        "px4-spacecraft.",
    ),
]
RunFolder = Annotated[
    Path, typer.Argument(metavar="RUN", help="A folder that 'identify -o' wrote.")
]


class InitialMomentum(StrEnum):
    """What is known of the momentum (Section 3.1)."""

    unknown = "unknown"
    at_rest = "at-rest"
    first_sample = "first-sample"


MomentumKnown = Annotated[
    InitialMomentum,
    typer.Option(
        "--initial-momentum",
        help="How the momentum is known. unknown: it is estimated; at-rest: the robot "
        "was at rest before its wheels spun up; first-sample: as in the paper, the "
        "first sample is subtracted (Eq. 24).",
    ),
]
