"""`orbident noise REST`."""

from pathlib import Path
from typing import Annotated

import typer

import orbident as oi
from orbident.cli.options import Force
from orbident.cli.output import Output, progress
from orbident.files.names import counted
from orbident.files.replacing import check_free, write_text


def noise(
    output: Output,
    rest: Annotated[
        Path,
        typer.Argument(
            metavar="REST", help="A recording of a robot at rest: CSV or Parquet."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="FILE",
            help="Write the 'sensors' section of a robot file there.",
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            metavar="FILE",
            help="Draw the Allan deviations in this file (HTML).",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Estimate the noise of sensors from a recording at rest.

    For each axis of gyro, accelerometer, attitude and position: white noise and, where
    the samples show it, noise that lasts.
    """
    import yaml

    from orbident.noise.rest_noise import noise_table, rest_noise, sensor_section

    for place in (out, plot):
        if place is not None:
            check_free(place, force)
    recording = oi.read_recording(rest)
    with progress("learning the noise"):
        found = rest_noise(recording)
    section = sensor_section(found)
    if plot is not None:
        from orbident.report.allan import write_allan

        write_allan(found, rest.name, plot)
    written = yaml.safe_dump(
        {"sensors": section}, sort_keys=False, default_flow_style=None
    )
    if out is not None:
        write_text(out, written)
    where = written.rstrip() if out is None else f"written: {out}"
    output.warn(
        f"{each.name}: {each.left_out} samples are spikes and left out"
        for each in found
        if each.left_out
    )
    checks = [each.check for each in found]
    output.warn(check.words for check in checks if not check.passed)
    output.say(
        f"estimated the noise of {counted(len(found), 'axis', 'axes')} from {rest}",
        "",
        noise_table(found),
        "",
        where,
    )
    axes = {
        each.name: {
            "samples": each.model.samples,
            "left_out": each.left_out,
            **{
                name: {
                    "value": level.value,
                    "std": level.std,
                    "interval_95": list(level.interval),
                    "unit": each.unit(name),
                }
                for name, level in each.model.levels.items()
            },
        }
        for each in found
    }
    output.write_json({"axes": axes, "sensors": section})
