"""The process that runs one command after the other, so that a case is cheap.

It reads one JSON request a line and answers each with one line. What the command writes
goes to files, by descriptor: words of libraries written in C are caught too.
"""

import gc
import io
import json
import os
import shutil
import sys
import threading
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any
from unittest.mock import patch

from case import CLOSED, DELETED, FIFO, STDIN

KILOBYTE = 1024


def serve() -> None:
    """Answer requests until there are none."""
    with os.fdopen(os.dup(0)) as requests, os.fdopen(os.dup(1), "w") as answers:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        _show_pages_for_a_moment()
        for line in requests:
            answers.write(json.dumps(_answer(json.loads(line))) + "\n")
            answers.flush()


def _show_pages_for_a_moment() -> None:
    """`orbident view` would serve until it is interrupted."""
    import orbident.viewer.server as server

    patch.object(
        server, "keep_moving", lambda page: page.advance(server.PERIOD)
    ).start()


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    folder = Path(request["folder"])
    os.chdir(folder)
    _set_up(folder, request["setting"])
    _forget_warnings()
    # From now on the peak is this case's.
    Path("/proc/self/clear_refs").write_text("5")
    status = _run(request["arguments"], Path(request["output"]))
    peak = _kilobytes("VmHWM") * KILOBYTE
    gc.collect()
    # What is left are imported modules, which need not be looked through each time.
    gc.freeze()
    return {"status": status, "peak": peak, "held": _kilobytes("VmRSS") * KILOBYTE}


def _set_up(folder: Path, setting: str) -> None:
    """Standard input, FIFOs, and a working directory that may be gone."""
    with suppress(OSError):
        os.close(0)
    sys.stdin = None  # pyright: ignore[reportAttributeAccessIssue]
    if setting != CLOSED:
        given = folder / STDIN
        os.open(given if given.exists() else os.devnull, os.O_RDONLY)
        sys.stdin = io.TextIOWrapper(os.fdopen(0, "rb", closefd=False))
    for path in folder.glob(f"{FIFO}*"):
        content = path.read_bytes()
        path.unlink()
        os.mkfifo(path)
        threading.Thread(target=_feed, args=(path, content), daemon=True).start()
    if setting == DELETED:
        shutil.rmtree(folder)


def _feed(path: Path, content: bytes) -> None:
    # Unlike `open`, this makes no file where the FIFO is gone.
    with suppress(OSError), os.fdopen(os.open(path, os.O_WRONLY), "wb") as written:
        written.write(content)


def _forget_warnings() -> None:
    """A warning is shown in every case, not only in the first that causes it."""
    warnings.filterwarnings("default", category=RuntimeWarning)


def _kilobytes(name: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{name}:"):
            return int(line.split()[1])
    raise LookupError(name)


def _run(arguments: list[str], output: Path) -> int:
    from orbident.cli.app import main

    sys.argv = ["orbident", *arguments]
    for descriptor, name in ((1, "out"), (2, "err")):
        written = os.open(output / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(written, descriptor)
        os.close(written)
    # As `accept_any_output` makes the streams of a process.
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(
            os.fdopen(os.dup(descriptor), "wb"),
            errors="backslashreplace",
            write_through=True,
        )
        for descriptor in (1, 2)
    )
    try:
        main()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 0
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.close()
    raise AssertionError("the command has not said its status")


if __name__ == "__main__":
    serve()
