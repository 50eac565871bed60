"""Where results go: tables for people, JSON for machines, progress for the patient."""

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from shutil import get_terminal_size
from typing import Any

from orbident.cli.options import Json, Quiet
from orbident.cli.streams import warn, wipe
from orbident.data_table import DataTable
from orbident.extras import MissingLibraryError
from orbident.files.replacing import check_place, write_text

WIDTH = 110
"""Columns of a table, in a narrower terminal too: a number is never cut short. A tree,
which is words, is as narrow as the terminal."""

SIGNS = {"trusted": ("✓", "32"), "with care": ("!", "33"), "refused": ("✗", "31")}
"""How a person sees a verdict: with a symbol, in a colour of ECMA-48."""

PERIOD = 600.0
"""Seconds before now whose progress predicts the time left: steps may take minutes."""


def with_sign(head: str, verdict: str) -> str:
    """A line with its verdict, as a person at a terminal sees it."""
    if not sys.stdout.isatty() or "NO_COLOR" in os.environ:
        return head
    symbol, colour = SIGNS[verdict]
    shown = f"\x1b[1;{colour}m{symbol} {verdict}\x1b[0m"
    return head.replace(f": {verdict},", f": {shown},")


class Output:
    """One verb's results, in words and as JSON."""

    def __init__(self, json_to: str | None, quiet: bool) -> None:
        """Refuse a place for the JSON before the work is done, not after.

        Raises:
            InputError: it is a folder, or in a folder that does not exist.
        """
        if json_to not in {None, "-"}:
            check_place(Path(str(json_to)))
        # With the JSON on standard output nothing else may stand there.
        self.quiet, self.silent = quiet, quiet or json_to == "-"
        self._json_to = json_to

    def say(self, *things: Any) -> None:
        """Words and tables for people; names are shown as they are, never as markup."""
        if self.silent:
            return
        wipe()
        for thing in things:
            # Words are for the terminal to wrap, so that a formula can be copied.
            print(thing if isinstance(thing, str) else self._drawn(thing))

    def warn(self, sentences: Iterable[str]) -> None:
        """Lines on standard error, quiet or not; before any results."""
        for sentence in sentences:
            warn(sentence)

    def _drawn(self, thing: Any) -> str:
        from rich.console import Console

        table, width = thing, min(WIDTH, get_terminal_size((WIDTH, 1)).columns)
        if isinstance(thing, DataTable):
            table, width = _in_columns(thing), WIDTH
        console = Console(width=width, highlight=False)
        with console.capture() as drawn:
            console.print(table, markup=False)
        return "\n".join(line.rstrip() for line in drawn.get().splitlines())

    def write_json(self, document: dict[str, Any]) -> None:
        """The machine-readable result, where it was asked for.

        Raises:
            InputError: the place cannot be written.
        """
        if self._json_to is None:
            return
        text = json.dumps(document, indent=1, allow_nan=False)
        if self._json_to == "-":
            wipe()
            print(text)
            return
        write_text(Path(self._json_to), text + "\n")


def _in_columns(table: DataTable) -> Any:
    """A table for the terminal: the title above, columns of numbers aligned right."""
    from rich.console import Group
    from rich.table import Table

    drawn = Table(box=None)
    for k, name in enumerate(table.head):
        right = any(not isinstance(row.cells[k], str) for row in table.rows)
        drawn.add_column(name, justify="right" if right else "left")
    for row in table.rows:
        drawn.add_row(*map(str, row.cells))
    return Group(*([f"{table.title}\n"] if table.title else []), drawn)


@contextmanager
def progress(what: str) -> Iterator[Any]:
    """A bar on standard error, none when it is no terminal.

    Yields:
        A function to be called with the fraction done, and with other words if they
        change; without a call the bar pulses.
    """
    # Late, as above: where help is wanted nothing is drawn.
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    wipe()
    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    console = Console(stderr=True)
    # FORCE_COLOR makes rich take a file for a terminal.
    hidden = not (console.is_terminal and sys.stderr.isatty())
    with Progress(
        *columns,
        console=console,
        transient=True,
        disable=hidden,
        speed_estimate_period=PERIOD,
    ) as bar:
        task = bar.add_task(what, total=None)

        def show(fraction: float, words: str = what) -> None:
            bar.update(task, total=1.0, completed=fraction, description=words)

        yield show


@contextmanager
def unless_missing(unmade: list[str], without: str) -> Iterator[None]:
    """Where a library is not installed that the block needs, say so in `unmade`.

    Behind what is missing stands what there is `without` it.
    """
    try:
        yield
    except MissingLibraryError as refusal:
        unmade.append(f"{refusal}; {without}")


def with_output(verb: Callable[..., None]) -> Callable[..., None]:
    """A verb that takes an `output`, as one with the options --json and --quiet."""
    parameters = dict(signature(verb).parameters)
    if parameters.pop("output", None) is None:
        return verb

    @wraps(verb)
    def run(*, json: str | None, quiet: bool, **given: Any) -> None:
        verb(Output(json, quiet), **given)

    for name, usual, kind in (("json", None, Json), ("quiet", False, Quiet)):
        parameters[name] = Parameter(
            name, Parameter.KEYWORD_ONLY, default=usual, annotation=kind
        )
    run.__annotations__ = {name: each.annotation for name, each in parameters.items()}
    vars(run)["__signature__"] = Signature(
        [each.replace(kind=Parameter.KEYWORD_ONLY) for each in parameters.values()]
    )
    return run
