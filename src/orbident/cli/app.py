"""The command `orbident`: how a run ends, and errors in one line.

Ctrl-C (SIGINT) and SIGTERM raise `KeyboardInterrupt` in the main thread, so that files
are closed and temporary ones removed. Compiled code that does not return, and imported
code that swallows the exception, would let the run go on: a second thread ends the
process when it has not ended by itself, and removes what was being written.
"""

import os
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from orbident.cli.streams import (
    accept_any_output,
    complain,
    drop_output,
    plain_warnings,
    wipe,
)
from orbident.errors import InputError
from orbident.files.replacing import undo_all

PATIENCE = 1.5
"""What it may take to unwind, s: users are promised two seconds."""

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class Interruption:
    """Which signal has asked this run to stop, if any has."""

    def __init__(self) -> None:
        """None has so far."""
        self.by: signal.Signals | None = None
        self._said = False

    def handle(self, number: int, _: object) -> None:
        """Raise at the first signal; later ones shall not disturb the unwinding."""
        if self.by is None:
            self.by = signal.Signals(number)
            raise KeyboardInterrupt

    def end(self, by: signal.Signals) -> int:
        """Say it once; the exit status that shells know: 128 and the signal."""
        if not self._said:
            self._said = True
            complain(WORDS[by])
        return 128 + by


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Let signals stop the block.

    A signal that is ignored from the start stays so, as shells want it of what runs in
    their background.
    """
    interruption = Interruption()
    heeded = [s for s in WORDS if signal.getsignal(s) is not signal.SIG_IGN]
    before = {s: signal.signal(s, interruption.handle) for s in heeded}
    # Python writes a signal's number there at once, whatever the main thread does.
    numbers, written = os.pipe()
    os.set_blocking(written, False)
    wakeup = signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    unraisable, sys.unraisablehook = sys.unraisablehook, _show_unraisable
    ended = threading.Event()
    arguments = numbers, ended, interruption
    threading.Thread(target=_watch, args=arguments, daemon=True).start()
    try:
        yield interruption
    finally:
        sys.unraisablehook = unraisable
        signal.set_wakeup_fd(wakeup)
        os.close(written)
        for each, handler in before.items():
            signal.signal(each, handler)
        if interruption.by is None:
            ended.set()


def _show_unraisable(unraisable: "sys.UnraisableHookArgs") -> None:
    """Where a finaliser has swallowed the interrupt, the second thread will end all."""
    if unraisable.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(unraisable)


def _watch(numbers: int, ended: threading.Event, interruption: Interruption) -> None:
    """End the process when it goes on for long after a signal."""
    with os.fdopen(numbers, "rb", buffering=0) as received:
        while number := received.read(1):
            if number[0] in set(WORDS) and not ended.wait(PATIENCE):
                undo_all()
                os._exit(interruption.end(signal.Signals(number[0])))


WRONG_INPUT = 2
"""What argparse ends with too."""
INTERNAL_ERROR = 70
"""EX_SOFTWARE of sysexits.h; a result that must not be trusted is 1."""


def main() -> None:
    """Run the command; every failure is one line on standard error."""
    accept_any_output()
    with interruptible() as interruption:
        status, why = INTERNAL_ERROR, ""
        # A verb may also end by itself when it is interrupted, or fail for that reason.
        with suppress(KeyboardInterrupt), plain_warnings():
            status, why = _run()
        if interruption.by is not None:
            status = interruption.end(interruption.by)
            with suppress(OSError):
                sys.stderr.flush()
            # Without the rest of the output: where compiled code met the interrupt,
            # Python would end by the signal itself; and what an interrupted write has
            # left in a buffer would be written twice.
            os._exit(status)
        if why:
            complain(why)
    sys.exit(status)


def _run() -> tuple[int, str]:
    """Run the verb that was asked for; the exit status, and why it failed."""
    # Late: the imports can be interrupted too.
    import typer

    from orbident.cli.verbs import app

    try:
        status = app(sys.argv[1:] or ["--help"], "orbident", standalone_mode=False)
        wipe()
        # Not at exit, where a full disk could not be reported.
        sys.stdout.flush()
    except OSError as error:
        return WRONG_INPUT, _system_refused(error)
    except InputError as error:
        return WRONG_INPUT, str(error)
    except MemoryError as error:
        return WRONG_INPUT, f"not enough memory: {error}"
    except typer.TyperException as error:
        return WRONG_INPUT, _wrong_usage(error)
    except Exception as error:
        return INTERNAL_ERROR, _internal_error(error)
    return status or 0, ""


def _system_refused(error: OSError) -> str:
    if error.filename is not None:
        return f"{error.filename}: {error.strerror or error}"
    try:
        Path.cwd()
    except FileNotFoundError:
        return "the folder that you are in was deleted; change to another with 'cd'"
    drop_output()
    return f"standard output: {error.strerror or error}"


def _wrong_usage(error: Any) -> str:
    message = error.format_message().replace("Value error, ", "").rstrip(".")
    context = getattr(error, "ctx", None)
    verb = "orbident" if context is None else context.command_path
    return f"{message}; see {verb} --help"


def _internal_error(error: Exception) -> str:
    # Typer takes an end of file in the middle of a verb for the user's wish to stop.
    cause = error.__cause__ if isinstance(error.__cause__, EOFError) else error
    if os.environ.get("ORBIDENT_TRACEBACK"):
        traceback.print_exception(cause)
    return (
        f"internal error: {type(cause).__name__}: {cause} (a bug; set "
        "ORBIDENT_TRACEBACK=1 to see where, and please report it)"
    )


if __name__ == "__main__":
    main()
