"""`orbident topics FILE [-o MAP]`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import Force, LogFile, Preset
from orbident.cli.output import Output, progress


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
    force: Force = False,
) -> None:
    """List what another tool's file holds and propose a topic map."""
    from orbident.files.names import counted
    from orbident.files.replacing import check_free
    from orbident.files.text import read_text, write_text
    from orbident.recordings.topics.presets import known_preset, preset_path
    from orbident.recordings.topics.topic_map import proposed_map

    if out is not None:
        check_free(out, force)
    with progress("reading") as done:
        surveyed = oi.survey_file(file, done)
    if preset is None:
        proposal = proposed_map(surveyed)
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
    output.write_json({"file": str(file), "topics": _rows(surveyed), "map": proposal})


def _rows(surveyed: Any) -> list[dict[str, Any]]:
    return [
        {
            "topic": each.topic.name,
            "type": each.topic.type,
            "messages": each.topic.count,
            "rate": each.rate,
            "names": list(each.labels),
        }
        for each in surveyed
    ]


def _lines(surveyed: Any) -> list[str]:
    rows = [("topic", "type", "messages", "rate (Hz)")]
    for each in surveyed:
        rate = "-" if each.rate is None else f"{each.rate:.5g}"
        rows.append((each.topic.name, each.topic.type, str(each.topic.count), rate))
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    return [
        f"{name:{widths[0]}}  {kind:{widths[1]}}  {count:>{widths[2]}}  "
        f"{rate:>{widths[3]}}"
        for name, kind, count, rate in rows
    ]
