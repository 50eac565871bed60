"""`orbident view ROBOT|RUN`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from orbident.cli.options import Json, Quiet


def view(
    shown: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT|RUN",
            help="A bundled name, a URDF, a robot file, or a folder that "
            "'identify -o' wrote.",
        ),
    ],
    recording: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="Replay this; of a RUN with the predicted motion beside it. "
            "Without it the joints have sliders, and the base answers.",
        ),
    ] = None,
    host: Annotated[
        str, typer.Option(help="Address to listen at; 0.0.0.0 for all networks.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(help="Port to listen at; 0 for a free one.", min=0, max=65535)
    ] = 8080,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Look at a robot, or at a recorded motion, in the browser; Ctrl-C ends it."""
    from orbident.cli.output import Output, prepare_jax, progress
    from orbident.viewer.pages import prepared
    from orbident.viewer.server import address, close, open_server, run

    output = Output(json, quiet)
    prepare_jax()
    with progress("preparing"):
        made = prepared(shown, recording)
        server = open_server(host, port)
    try:
        page = made.page(server)
        output.warn(made.warnings)
        url = address(server, host)
        output.say(f"{shown} is shown at {url}; Ctrl-C ends it")
        output.write_json({"shown": shown, "url": url})
        sys.stdout.flush()
        run(page)
    finally:
        close(server)
