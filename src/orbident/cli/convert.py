"""`orbident convert BAG --map MAP -o REC`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from orbident.cli.options import BagFile, Json, Quiet


def convert(
    bag: BagFile,
    topic_map: Annotated[
        Path, typer.Option("--map", metavar="MAP", help="What each topic feeds (YAML).")
    ],
    out: Annotated[
        Path, typer.Option("-o", metavar="REC", help="The recording: .csv or .parquet.")
    ],
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Make a recording of a ROS bag or MCAP file."""
    from orbident.cli.output import Output, progress
    from orbident.files.replacing import check_place
    from orbident.recordings.bags.convert import convert_bag

    output = Output(json, quiet)
    check_place(out)
    with progress("converting") as done:
        report = convert_bag(bag, topic_map, out, done)
    output.warn(report.warnings)
    output.say(*_lines(report))
    output.write_json(report.to_json())


def _lines(report: Any) -> list[Any]:
    from rich.table import Table

    heads = ("topic", "messages", "used", "rate (Hz)", "from (s)", "to (s)", "time")
    table = Table(*heads, box=None)
    for column in table.columns[1:-1]:
        column.justify = "right"
    for topic in report.topics:
        table.add_row(
            topic.topic,
            str(topic.messages),
            str(topic.used),
            "-" if topic.rate is None else f"{topic.rate:.6g}",
            f"{topic.start:.3f}",
            f"{topic.end:.3f}",
            topic.time if topic.clock is None else f"{topic.time}, {topic.clock}",
        )
    odd = [sentence for topic in report.topics for sentence in topic.sentences()]
    return [
        table,
        *odd,
        f"{report.recording}: {report.samples} samples over {report.duration:g} s",
    ]
