"""All verbs of `orbident`, as Typer knows them."""

import sys
from typing import Annotated

import typer

from orbident.cli.campaign import campaign
from orbident.cli.check import check
from orbident.cli.compare import compare
from orbident.cli.convert import convert
from orbident.cli.demo import demo
from orbident.cli.doctor import doctor
from orbident.cli.excite import excite
from orbident.cli.export import export
from orbident.cli.identify import identify
from orbident.cli.inspect import inspect
from orbident.cli.live import live
from orbident.cli.new import new
from orbident.cli.noise import noise
from orbident.cli.output import with_output
from orbident.cli.report import report
from orbident.cli.robots import robots
from orbident.cli.sample import sample
from orbident.cli.simulate import simulate
from orbident.cli.streams import show_at_work
from orbident.cli.study import study
from orbident.cli.topics import topics
from orbident.cli.validate import validate
from orbident.cli.view import view
from orbident.cli.weigh import weigh

app = typer.Typer(
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Identify every inertial parameter of a free-flying space manipulator.",
    epilog="Exit status: 0 done, 1 the result must not be trusted, 2 wrong input, "
    "70 internal error, 130 interrupted (Ctrl-C), 143 terminated.",
)
EXAMPLES = {
    demo: "orbident demo",
    robots: "orbident robots",
    new: "orbident new robot.yaml --joints 3 --wheels 3",
    check: "orbident check robot.yaml",
    inspect: "orbident inspect servicer.yaml --trajectory excite.yaml",
    topics: "orbident topics table.bag -o map.yaml",
    convert: "orbident convert table.bag --map map.yaml -o flight.parquet",
    excite: "orbident excite servicer.yaml --duration 80 -o excite.yaml",
    sample: "orbident sample excite.yaml --rate 100 -o commands.csv",
    simulate: "orbident simulate servicer.yaml excite.yaml --noise sensors -o r.csv",
    noise: "orbident noise rest.csv -o sensors.yaml --plot allan.html",
    identify: "orbident identify servicer.yaml flight.csv -o run",
    report: "orbident report run --force",
    weigh: "orbident weigh servicer.yaml burn.csv",
    validate: "orbident validate run other_flight.csv",
    compare: "orbident compare before after",
    export: "orbident export run -o identified.urdf",
    view: "orbident view run --recording other_flight.csv",
    live: "orbident live servicer.yaml --udp 5005 --view",
    study: "orbident study spatial --noise paper --seeds 20",
    doctor: "orbident doctor",
}
"""Every verb, in the order of the help, with a command that its help shows."""

for verb, example in EXAMPLES.items():
    app.command(epilog=f"Example: {example}")(with_output(verb))
app.add_typer(
    campaign, name="campaign", epilog="Example: orbident campaign spec.yaml -o campaign"
)


def _print_version(wanted: bool) -> bool:
    if wanted:
        from importlib.metadata import version as installed

        print(f"orbident {installed('orbident')}")
        raise typer.Exit
    return wanted


@app.callback()
def _for_all_verbs(
    context: typer.Context,
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
    if context.invoked_subcommand and not {"-h", "--help"} & {*sys.argv}:
        show_at_work(context.invoked_subcommand)
