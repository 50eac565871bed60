"""The command `orbident`: verbs, exit statuses, and errors in one line."""

import os
import sys

import click
import typer

from orbident.cli.identify import identify
from orbident.cli.inspect import inspect
from orbident.cli.robots import robots
from orbident.cli.simulate import simulate
from orbident.cli.study import study
from orbident.cli.validate import validate
from orbident.errors import InputError

UNTRUSTED = 1
WRONG_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
    help="Identify every inertial parameter of a free-flying space manipulator.",
    epilog="Exit status: 0 done, 2 wrong input, 1 the result must not be trusted.",
)
for verb in (robots, inspect, simulate, identify, validate, study):
    app.command()(verb)


@app.callback(invoke_without_command=True)
def _version(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version."),
) -> None:
    if version:
        from importlib.metadata import version as installed

        print(f"orbident {installed('orbident')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


def main() -> None:
    """Run the command; every failure is one line on standard error."""
    try:
        status = app(standalone_mode=False)
    except InputError as error:
        status = _complain(str(error), WRONG_INPUT)
    except click.ClickException as error:
        status = _complain(error.format_message(), error.exit_code)
    except (KeyboardInterrupt, click.Abort):
        status = _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has gone: nothing is left to be said.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 0
    except Exception as error:
        if os.environ.get("ORBIDENT_TRACEBACK"):
            raise
        status = _complain(
            f"internal error: {type(error).__name__}: {error} "
            "(a bug; set ORBIDENT_TRACEBACK=1 to see where, and please report it)",
            UNTRUSTED,
        )
    sys.exit(status)


def _complain(message: str, status: int) -> int:
    print(f"orbident: {' '.join(message.split())}", file=sys.stderr)
    return status


if __name__ == "__main__":
    main()
