"""Arguments and options that several verbs share."""

import os
import shlex
import sys
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.choices import InitialMomentum
from orbident.errors import InputError


def _bundled(incomplete: str) -> list[str]:
    return [name for name in oi.bundled_robots() if name.startswith(incomplete)]


def _presets(incomplete: str) -> list[str]:
    from orbident.recordings.topics.presets import presets

    return [name for name in presets() if name.startswith(incomplete)]


RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A bundled name, a robot file, or a URDF, xacro, MJCF or SDF file.",
        autocompletion=_bundled,
    ),
]
Json = Annotated[
    str | None,
    typer.Option(
        "--json",
        metavar="FILE|-",
        help="Write the result there as JSON; - is standard output. A FILE that is "
        "there already is replaced.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but warnings.")]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        min=1,
        help="Number of processes (default: one for each processor).",
    ),
]
RecordingFile = Annotated[
    Path, typer.Argument(metavar="REC", help="A recording: CSV or Parquet.")
]
NewRecording = Annotated[
    Path,
    typer.Option("-o", metavar="REC", help="The recording to write, .csv or .parquet."),
]

LogFile = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="A ROS bag (of ROS 2 its folder), or a file of MCAP, MATLAB, HDF5, PX4 "
        "ULog, NumPy (.npz), Parquet, CSV or other text, or the folder of NASA's 42.",
    ),
]
Preset = Annotated[
    str | None,
    typer.Option(
        "--preset",
        metavar="NAME",
        help="A map that comes with Orbident: astrobee, basilisk, cepheus, kentucky, "
        "nasa-42, optitrack, phasespace, px4-spacecraft, spot, xact.",
        autocompletion=_presets,
    ),
]
Start = Annotated[
    float | None,
    typer.Option(
        "--from",
        metavar="SECONDS",
        help="Use only what was recorded at this time (column t) or later.",
    ),
]
End = Annotated[
    float | None,
    typer.Option(
        "--to",
        metavar="SECONDS",
        help="Use only what was recorded at this time (column t) or earlier.",
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace what is there already.")]
RunFolder = Annotated[
    Path, typer.Argument(metavar="RUN", help="A folder that 'identify -o' wrote.")
]


MomentumKnown = Annotated[
    InitialMomentum,
    typer.Option(
        "--initial-momentum",
        help="How the momentum is known. unknown: it is estimated. at-rest: it is "
        "zero, as the robot was at rest before its wheels spun up. first-sample: as in "
        "the paper, the first sample is subtracted (Eq. 24).",
    ),
]


def as_typed() -> dict[str, str]:
    """The command line of this run, and the date and time (UTC) of its result."""
    typed = os.fsencode(shlex.join(["orbident", *sys.argv[1:]]))
    return {
        # A file's name may be no text.
        "command": typed.decode(errors="backslashreplace"),
        "date": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC",
    }


def cut_to_times(table: Any, start: float | None, end: float | None) -> Any:
    """Only the rows of a recording from --from to --to, if either is given.

    Raises:
        InputError: --from does not come before --to, or hardly a row is left.
    """
    if start is None and end is None:
        return table
    start, end = -inf if start is None else start, inf if end is None else end
    if not start < end:
        raise InputError(
            f"--from {start:g} does not come before --to {end:g}; give two times "
            "in seconds, the earlier one as --from"
        )
    return table.between(start, end)
