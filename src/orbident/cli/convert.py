"""`orbident convert FILE --map MAP -o REC`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import Force, LogFile, NewRecording, Preset
from orbident.cli.output import Output, progress
from orbident.data_table import Numeric, table_of
from orbident.files.replacing import check_free


def convert(
    output: Output,
    file: LogFile,
    out: NewRecording,
    topic_map: Annotated[
        Path | None,
        typer.Option(
            "--map",
            metavar="MAP",
            help="A topic map (YAML): which columns each topic feeds.",
        ),
    ] = None,
    preset: Preset = None,
    force: Force = False,
) -> None:
    """Convert a file of ROS, MATLAB, PX4 or others to a recording."""
    from orbident.recordings.topics.presets import known_preset

    chosen = topic_map if preset is None else known_preset(preset)
    if chosen is None or None not in {topic_map, preset}:
        raise oi.InputError(
            "give either '--map MAP', which 'orbident topics' proposes, or "
            "'--preset NAME'"
        )
    check_free(out, force)
    with progress("converting") as done:
        report = oi.convert_file(file, chosen, out, done)
    output.warn(report.warnings)
    output.say(*_lines(file, report))
    output.write_json(report.to_json())


def _lines(file: Path, report: Any) -> list[Any]:
    head = ("topic", "messages", "used", "rate (Hz)", "from (s)", "to (s)", "time")
    rows = (
        (
            topic.topic,
            Numeric(topic.messages, "d"),
            Numeric(topic.used, "d"),
            Numeric(topic.rate, ".6g"),
            Numeric(topic.start, ".3f"),
            Numeric(topic.end, ".3f"),
            topic.time if topic.clock is None else f"{topic.time}, {topic.clock}",
        )
        for topic in report.topics
    )
    return [
        f"converted {file}: {report.samples} samples over {report.duration:g} s",
        table_of("", head, rows),
        *(sentence for topic in report.topics for sentence in topic.sentences()),
        f"written: {report.recording}",
    ]
