"""Standard output and standard error: for any reader, also one that goes away."""

import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from orbident.errors import readable


class _Pipe(io.FileIO):
    """What is written after the reader has gone is dropped.

    So `| head -1` changes neither what a verb does nor its exit status.
    """

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data) or 0
        except BrokenPipeError:
            return len(data)


def accept_any_output() -> None:
    """A closed stream, a reader that goes, or a strange name is no error."""
    sys.stdout = _patient(sys.stdout, sys.__stdout__)
    sys.stderr = _patient(sys.stderr, sys.__stderr__)


def _patient(stream: TextIO | None, original: TextIO | None) -> TextIO:
    if stream is None:
        # The stream was closed before the command started.
        return Path(os.devnull).open("w")
    if stream is not original:
        # A test or a notebook has put its own there.
        return stream
    return io.TextIOWrapper(
        io.BufferedWriter(_Pipe(stream.fileno(), "w", closefd=False)),
        encoding=stream.encoding,
        errors="backslashreplace",
        line_buffering=stream.isatty() or stream is sys.__stderr__,
    )


def drop_output() -> None:
    """What is still buffered is not to fail once more when Python exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complain(message: str) -> None:
    """One line on standard error."""
    wipe()
    print(f"orbident: {readable(' '.join(message.split()))}", file=sys.stderr)


def warn(sentence: str) -> None:
    """One line on standard error about a result that is there."""
    complain(f"warning: {sentence}")


@contextmanager
def plain_warnings() -> Iterator[None]:
    """What NumPy, SciPy or Arrow warn of is said as one of our own lines."""

    def show(message: Warning | str, _: type[Warning], file: str, line: int, *__: Any):
        warn(
            f"{message} in a computation ({Path(file).name}:{line}); check the input "
            "for numbers that cannot be, and please report it"
        )

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


_shown = ""


def show_at_work(verb: str) -> None:
    """Say that the verb is at work; nothing where standard error is no terminal."""
    global _shown
    if sys.stderr.isatty():
        _shown = f"orbident {verb}: working ..."
        print(_shown, end="\r", file=sys.stderr, flush=True)


def wipe() -> None:
    """Make room for what the verb says."""
    global _shown
    if _shown:
        print(" " * len(_shown), end="\r", file=sys.stderr, flush=True)
        _shown = ""
