"""The command `orbident`: how a run ends, and errors in one line."""

import os
import sys
import traceback
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from orbident.cli.interruption import interruptible
from orbident.cli.streams import (
    accept_any_output,
    complain,
    drop_output,
    plain_warnings,
    wipe,
)
from orbident.errors import InputError

WRONG_INPUT = 2
INTERNAL_ERROR = 70
"""EX_SOFTWARE of sysexits.h; a result that must not be trusted is 1."""


class Ended(NamedTuple):
    """How a run ended."""

    status: int
    why: str = ""


def main() -> None:
    """Run the command; every failure is one line on standard error."""
    accept_any_output()
    with interruptible() as interruption:
        ended = Ended(INTERNAL_ERROR)
        # A verb may also end by itself when it is interrupted, or fail for that reason.
        with suppress(KeyboardInterrupt), plain_warnings():
            ended = _run()
        status = ended.status
        if interruption.by is not None:
            _end_now(interruption.end(interruption.by))
        elif ended.why:
            complain(ended.why)
    sys.exit(status)


def _end_now(status: int) -> NoReturn:
    """End with this status, without the rest of the output.

    Where compiled code met the interrupt, Python would end by the signal itself; and
    what an interrupted write has left in a buffer would be written twice.
    """
    with suppress(OSError):
        sys.stderr.flush()
    os._exit(status)


def _run() -> Ended:
    """Run the verb that was asked for."""
    # Late: the imports can be interrupted too.
    import typer

    from orbident.cli.verbs import app

    try:
        status = app(sys.argv[1:] or ["--help"], "orbident", standalone_mode=False)
        wipe()
        # Not at exit, where a full disk could not be reported.
        sys.stdout.flush()
    except OSError as error:
        return Ended(WRONG_INPUT, _system_refused(error))
    except InputError as error:
        return Ended(WRONG_INPUT, str(error))
    except MemoryError as error:
        return Ended(WRONG_INPUT, f"not enough memory: {error}")
    except typer.TyperException as error:
        return Ended(WRONG_INPUT, _wrong_usage(error))
    except Exception as error:
        return Ended(INTERNAL_ERROR, _internal_error(error))
    return Ended(status or 0)


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
