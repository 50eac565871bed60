"""All verbs of `orbident`, as Typer knows them."""

from typing import Annotated

import typer

from orbident.cli.campaign import campaign
from orbident.cli.compare import compare
from orbident.cli.convert import convert
from orbident.cli.doctor import doctor
from orbident.cli.excite import excite
from orbident.cli.export import export
from orbident.cli.identify import identify
from orbident.cli.inspect import inspect
from orbident.cli.live import live
from orbident.cli.noise import noise
from orbident.cli.report import report
from orbident.cli.robots import robots
from orbident.cli.sample import sample
from orbident.cli.simulate import simulate
from orbident.cli.study import study
from orbident.cli.topics import topics
from orbident.cli.validate import validate
from orbident.cli.view import view
from orbident.cli.weigh import weigh

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Identify every inertial parameter of a free-flying space manipulator.",
    epilog="Exit status: 0 done, 1 the result must not be trusted, 2 wrong input, "
    "70 internal error, 130 interrupted (Ctrl-C), 143 terminated.",
)
for verb in (
    robots,
    inspect,
    topics,
    convert,
    excite,
    sample,
    simulate,
    noise,
    identify,
    report,
    weigh,
    validate,
    compare,
    export,
    view,
    live,
    study,
    doctor,
):
    app.command()(verb)
app.add_typer(campaign, name="campaign")


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
