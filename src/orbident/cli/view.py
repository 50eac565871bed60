"""`orbident view ROBOT|RUN`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from orbident.cli.options import Force
from orbident.cli.output import Output, progress
from orbident.cli.streams import drop_output
from orbident.errors import InputError
from orbident.files.replacing import check_free


def view(
    output: Output,
    shown: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT|RUN",
            help="A bundled name, a robot file, a URDF, xacro, MJCF or SDF file, or a "
            "folder that 'identify -o' wrote.",
        ),
    ],
    recording: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="Recording to replay. For a RUN, the prediction is overlaid. Without "
            "it: sliders for the joints.",
        ),
    ] = None,
    host: Annotated[
        str,
        typer.Option(
            help="Address to listen at; 0.0.0.0 for all networks. The printed address "
            "then holds a secret token, without which nobody can see the robot."
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(help="Port to listen at; 0 for a free one.", min=0, max=65535)
    ] = 8080,
    record: Annotated[
        Path | None,
        typer.Option(
            metavar="CLIP",
            help="Draw the replay as a moving picture (.gif) instead; no browser is "
            "needed.",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Show a robot or a recorded motion in the browser.

    Ctrl-C ends it.
    """
    if record is not None:
        _recorded(output, shown, recording, record, force)
        return
    from orbident.viewer.pages import prepared
    from orbident.viewer.server import close, keep_moving, open_server

    with progress("preparing"):
        page_on, warnings = prepared(shown, recording)
        served = open_server(host, port)
    try:
        page = page_on(served.server)
        output.warn(warnings)
        if served.is_open:
            output.warn(
                [
                    "the viewer is open to the network: whoever has the address "
                    f"{served.url} with its token can see the robot and move it, and "
                    "it is sent unencrypted; leave out --host to keep the viewer on "
                    "this machine"
                ]
            )
        output.say(f"{shown} is shown at {served.url}; Ctrl-C ends it")
        output.write_json({"shown": shown, "url": served.url})
        sys.stdout.flush()
        keep_moving(page)
    except KeyboardInterrupt:
        # An interrupted write may have left in the buffer what was written already.
        drop_output()
        raise
    finally:
        close(served.server)


def _recorded(
    output: Output, shown: str, recording: Path | None, clip: Path, force: bool
) -> None:
    """Write the replay as a moving picture."""
    from orbident.recordings.tables import read_recording
    from orbident.report.clip import check_clip, write_clip
    from orbident.scene.shown import to_be_shown

    check_clip(clip)
    check_free(clip, force)
    if recording is None:
        raise InputError(
            "--record: there is no motion to draw; name a recording with --recording"
        )
    with progress("drawing") as done:
        found = to_be_shown(shown)
        replay = found.replay(read_recording(recording))
        frames = write_clip(found.scene, replay, clip, done)
    output.warn([*found.scene.warnings, *replay.warnings])
    output.say(f"written: {clip}, {frames} frames")
    output.write_json({"shown": shown, "clip": str(clip), "frames": frames})
