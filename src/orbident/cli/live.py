"""`orbident live ROBOT`."""

import sys
from contextlib import ExitStack
from json import dumps
from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.options import RobotName
from orbident.cli.streams import warn, wipe
from orbident.files.replacing import check_place

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})


def live(
    robot: RobotName,
    udp: Annotated[
        int | None,
        typer.Option(
            metavar="PORT",
            help="Read datagrams at this port instead of standard input; each has one "
            "line or several. Ctrl-C ends it.",
            min=0,
            max=65535,
        ),
    ] = None,
    host: Annotated[
        str | None,
        typer.Option(
            help="Address to receive datagrams at (default 127.0.0.1, for this machine "
            "alone). With 0.0.0.0, anybody on the network can send samples."
        ),
    ] = None,
    every: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="Time from one estimate to the next, by the times of the samples.",
        ),
    ] = 1.0,
    velocity_std: Annotated[
        float | None,
        typer.Option(
            metavar="M/S",
            help="Standard deviation of a sample of velocity.x, .y, .z, m/s. Without "
            "it these columns are not used, and the mass is not determined.",
        ),
    ] = None,
    state: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Keep the state of the filter in this file, written at every "
            "estimate, and continue from it at the next start.",
        ),
    ] = None,
    view: Annotated[
        bool,
        typer.Option(
            "--view", help="Show the estimates in a browser of this machine too."
        ),
    ] = False,
) -> None:
    """Identify while samples arrive, as lines of CSV or JSON."""
    from orbident.live.session import Session
    from orbident.live.sources import Datagrams, lines_of_input

    _check_number("--every", every)
    _check_number("--velocity-std", velocity_std)
    if state is not None:
        check_place(state)
    described = oi.load_robot(robot)
    if host is not None and udp is None:
        raise oi.InputError(
            "--host: standard input is read; add --udp PORT, or leave out --host"
        )
    sockets = None if udp is None else Datagrams(host or "127.0.0.1", udp)
    source = "standard input" if sockets is None else f"UDP port {sockets.port}"
    if sockets is not None and host is not None and host not in LOOPBACK:
        warn(
            f"samples are taken from whoever can reach {host}, port {sockets.port}; "
            "leave out --host to take them from this machine alone"
        )
    session = Session(described, source, every, velocity_std, state)
    start, sinks = session.start(), [_print]
    with ExitStack() as opened:
        if view:
            from orbident.viewer.live_page import LivePage

            page = LivePage(start)
            opened.callback(page.close)
            sinks.append(page.send)
            start["view"] = page.url
        if sockets is not None:
            start["udp"] = sockets.port
        _print(start)
        given = sockets.lines() if sockets else lines_of_input(sys.stdin)
        try:
            for lines in given:
                session.take(lines, sinks)
        except KeyboardInterrupt:
            lost, waiting = (sockets.lost, sockets.waiting) if sockets else (0, 0)
            session.end(sinks, lost, waiting)
            raise
        session.end(sinks)


def _check_number(option: str, number: float | None) -> None:
    if number is not None and not 0 < number < float("inf"):
        raise oi.InputError(f"{option}: found {number}; give a number above zero")


def _print(document: dict[str, Any]) -> None:
    wipe()
    print(dumps(document, allow_nan=False), flush=True)
