"""The command as a process that cannot outlive its test."""

import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

ORBIDENT = (sys.executable, "-m", "orbident.cli.app")
LIMIT = 300.0
"""s; the slowest takes some 20 s on a machine with nothing else to do."""


WITH_SIGINT = (
    "import os, signal, sys; "
    "signal.signal(signal.SIGINT, signal.{}); os.execvp(sys.argv[1], sys.argv[1:])"
)
"""Starts a command where Ctrl-C is heeded, also where tests run in the background; or
ignored, as a shell starts what runs in the background of a script."""


def finished(
    *command: object, limit: float = LIMIT, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Any command, run to its end."""
    caught: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.run(
        [*map(str, command)],
        text=True,
        timeout=limit,
        check=False,
        **(caught | options),
    )


@contextmanager
def started(
    *arguments: object,
    command: Sequence[str] = ORBIDENT,
    ignoring_interrupts: bool = False,
    limit: float = LIMIT,
    **options: Any,
) -> Iterator[subprocess.Popen[str]]:
    """A command that is killed when the block ends, or takes too long.

    Args:
        arguments: of the command.
        command: `orbident`, or another.
        ignoring_interrupts: as a shell starts what runs in a script's background.
        limit: s, that it may take.
        options: of `subprocess.Popen`.
    """
    caught: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    start = WITH_SIGINT.format("SIG_IGN" if ignoring_interrupts else "SIG_DFL")
    process = subprocess.Popen(
        [sys.executable, "-c", start, *command, *map(str, arguments)],
        text=True,
        **(caught | options),
    )
    # A read that waits for a line ends with the process.
    timer = threading.Timer(limit, process.kill)
    timer.start()
    try:
        yield process
    finally:
        timer.cancel()
        process.kill()
        process.communicate(timeout=LIMIT)
