"""The command `orbident`: verbs, exit statuses, and errors in one line."""

import io
import os
import sys
from typing import Annotated

import typer

from orbident.cli.compare import compare
from orbident.cli.convert import convert
from orbident.cli.excite import excite
from orbident.cli.export import export
from orbident.cli.identify import identify
from orbident.cli.inspect import inspect
from orbident.cli.report import report
from orbident.cli.robots import robots
from orbident.cli.sample import sample
from orbident.cli.simulate import simulate
from orbident.cli.study import study
from orbident.cli.topics import topics
from orbident.cli.validate import validate
from orbident.cli.view import view
from orbident.cli.weigh import weigh
from orbident.errors import InputError

UNTRUSTED = 1
WRONG_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Identify every inertial parameter of a free-flying space manipulator.",
    epilog="Exit status: 0 done, 2 wrong input, 1 the result must not be trusted.",
)
for verb in (
    robots,
    inspect,
    topics,
    convert,
    excite,
    sample,
    simulate,
    identify,
    report,
    weigh,
    validate,
    compare,
    export,
    view,
    study,
):
    app.command()(verb)


def _print_version(wanted: bool) -> bool:
    if wanted:
        from importlib.metadata import version as installed

        print(f"orbident {installed('orbident')}")
        raise typer.Exit
    return wanted


@app.callback()
def _for_all_verbs(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the version.",
        ),
    ] = False,
) -> None:
    """Options that stand before the verb."""


def main() -> None:
    """Run the command; every failure is one line on standard error."""
    _accept_any_output()
    try:
        status = app(sys.argv[1:] or ["--help"], "orbident", standalone_mode=False)
        # Not at exit, where a reader that has gone could not be caught.
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit):
        # The reader of our output has gone, which Typer answers with SystemExit:
        # nothing is left to be said.
        _drop_output()
        status = 0
    except OSError as error:
        if error.filename is None:
            _drop_output()
        status = _complain(_refusal(error), WRONG_INPUT)
    except (InputError, MemoryError, typer.TyperException) as error:
        status = _complain(_refusal(error), WRONG_INPUT)
    except (KeyboardInterrupt, typer.Abort):
        status = _complain("interrupted", INTERRUPTED)
    except Exception as error:
        if os.environ.get("ORBIDENT_TRACEBACK"):
            raise
        status = _complain(
            f"internal error: {type(error).__name__}: {error} "
            "(a bug; set ORBIDENT_TRACEBACK=1 to see where, and please report it)",
            UNTRUSTED,
        )
    sys.exit(status or 0)


def _refusal(error: Exception) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'}: {error.strerror or error}"
    if isinstance(error, typer.TyperException):
        message = error.format_message().replace("Value error, ", "").rstrip(".")
        context = getattr(error, "ctx", None)
        verb = "orbident" if context is None else context.command_path
        return f"{message}; see {verb} --help"
    if isinstance(error, MemoryError):
        return f"not enough memory: {error}"
    return str(error)


def _accept_any_output() -> None:
    """Neither a name that the terminal cannot show nor a closed output is an error."""
    if sys.stdout is None:
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """What is still buffered is not to fail once more when Python exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain(message: str, status: int) -> int:
    print(f"orbident: {' '.join(message.split())}", file=sys.stderr)
    return status


if __name__ == "__main__":
    main()
