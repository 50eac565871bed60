"""`orbident compare BEFORE AFTER`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import orbident as oi
from orbident.cli.output import Output
from orbident.data_table import table_of


def compare(
    output: Output,
    before: Annotated[
        Path, typer.Argument(metavar="BEFORE", help="A RUN that 'identify -o' wrote.")
    ],
    after: Annotated[
        Path, typer.Argument(metavar="AFTER", help="A RUN of the same robot.")
    ],
    body: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="The body that holds what was captured; by default the one that "
            "explains the change best.",
        ),
    ] = None,
) -> None:
    """Find what a robot captured or let go between two RUNs."""
    comparison = oi.compare(oi.load_result(before), oi.load_result(after), body)
    output.warn(comparison.warnings)
    output.say(*_lines(comparison))
    output.write_json(comparison.to_json())
    if comparison.status == "rejected":
        raise typer.Exit(1)


def _lines(comparison: Any) -> list[Any]:
    change = comparison.change
    if change is None:
        return ["refused"]
    lines: list[Any] = [
        f"{comparison.status}: {comparison.of} differ by chi-square "
        f"{change.value:.4g}, expected {change.dof} (p {change.p:.2g})"
    ]
    if comparison.explanations:
        lines += ["", _explanations(comparison.explanations)]
    if comparison.added is not None:
        lines += ["", *_added(comparison)]
    return lines


def _explanations(explanations: Any) -> Any:
    rows = (
        (
            *(e.body, f"{e.left.value:.4g}", f"{e.left.dof}", f"{e.left.p:.2g}"),
            f"{e.probability:.2g}",
        )
        for e in explanations
    )
    head = "joined", "chi-square left", "expected", "p", "probability"
    return table_of("", head, rows)


def _added(comparison: Any) -> list[Any]:
    added, body = comparison.added, comparison.body
    did = "let go" if added.mass.value < 0 else "captured"
    rows = [("mass, kg", *_numbers(added.mass.value, added.mass.std))]
    for what, unit, found in (
        ("", "m", added.com),
        (", about its CM", "kg m^2", added.I_com),
        (f", about the origin of {body}", "kg m^2", added.I_origin),
    ):
        for name, _, value, std in found:
            rows.append((f"{name}{what}, {unit}", *_numbers(value, std)))
    table = table_of("", ("", "value", "std", "95 % from", "to"), rows)
    lines: list[Any] = [f"{did} on {body}; in the frame of {body}", table]
    return lines + [
        f"{name} is not determined: {why}"
        for name, why in comparison.undetermined.items()
    ]


def _numbers(value: float, std: float) -> list[str]:
    from orbident.identified.single_body import interval_95

    if value != value:
        return ["-"] * 4
    low, high = interval_95(value, std)
    return [f"{value:.6g}", f"{std:.2g}", f"{low:.6g}", f"{high:.6g}"]
