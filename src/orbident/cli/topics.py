"""`orbident topics FILE [-o MAP]`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import Force, LogFile, Preset
from orbident.cli.output import Output, progress
from orbident.data_table import Numeric
from orbident.files.names import counted
from orbident.files.replacing import check_free, write_text
from orbident.files.text import read_text


def topics(
    output: Output,
    file: LogFile,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            metavar="MAP",
            help="Write the proposed map to this file instead of printing it.",
        ),
    ] = None,
    preset: Preset = None,
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="ROBOT",
            help="The robot whose joints and wheels the messages may name.",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """List what another tool's file holds and propose a topic map."""
    from orbident.recordings.topics.presets import known_preset, preset_path
    from orbident.recordings.topics.topic_map import proposed_map

    if out is not None:
        check_free(out, force)
    with progress("reading") as done:
        surveyed = oi.survey_file(file, done)
    output.warn(surveyed[0].notes)
    if preset is None:
        named = None if robot is None else oi.load_robot(robot)
        proposal = proposed_map(surveyed, named)
    else:
        proposal = read_text(preset_path(known_preset(preset)))
    if out is not None:
        write_text(out, proposal)
    # As comments, so that what is printed is a map as a whole.
    output.say(f"# {file} holds {counted(len(surveyed), 'topic')}")
    output.say(*(f"# {line}" for line in _lines(surveyed)))
    if out is None:
        output.say(proposal.rstrip())
    else:
        output.say(f"# written: {out}; decide at every TODO in it")
    output.write_json(
        {
            "file": str(file),
            "topics": [
                {
                    "topic": each.topic.name,
                    "type": each.topic.type,
                    "messages": each.topic.count,
                    "rate": each.rate,
                    "names": list(each.labels),
                    "ranges": {name: list(x) for name, x in each.ranges.items()},
                    "offset": each.offset,
                    "drift": each.drift,
                }
                for each in surveyed
            ],
            "map": proposal,
            "warnings": list(surveyed[0].notes),
        }
    )


def _lines(surveyed: Any) -> list[str]:
    rows = [["topic", "type", "messages", "rate (Hz)"]]
    clocks = any(each.offset is not None for each in surveyed)
    if clocks:
        rows[0] += ["header - receive (s)", "drift (ppm)"]
    for each in surveyed:
        row = [each.topic.name, each.topic.type, str(each.topic.count)]
        row.append(str(Numeric(each.rate, ".5g")))
        if clocks:
            ppm = None if each.drift is None else 1e6 * each.drift
            row += [str(Numeric(each.offset, ".4f")), str(Numeric(ppm, ".0f"))]
        rows.append(row)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            f"{cell:{'<' if k < 2 else '>'}{width}}"
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
