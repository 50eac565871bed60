"""The reference of the command line, made from the command when the site is built."""

from collections.abc import Iterator
from typing import Any

import typer

from orbident.cli.verbs import app

PLACE = "<!-- verbs -->"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put all verbs where a page has the place for them."""
    if PLACE not in markdown:
        return markdown
    return markdown.replace(PLACE, "\n".join(reference()))


def reference() -> Iterator[str]:
    """Every verb: what it does, an example, its arguments and options."""
    group: Any = typer.main.get_command(app)
    with group.make_context("orbident", ["robots"]) as context:
        for name, verb in group.commands.items():
            yield from _section(name, verb, context)
            for inner, part in getattr(verb, "commands", {}).items():
                yield from _section(f"{name} {inner}", part, context)


def _section(name: str, verb: Any, context: Any) -> Iterator[str]:
    arguments = [p for p in verb.params if p.param_type_name == "argument"]
    options = [p for p in verb.params if p.param_type_name == "option"]
    words = " ".join(p.metavar for p in arguments)
    yield f"## {name}\n\n{verb.help}\n"
    yield f"```text\norbident {name} {words} [OPTIONS]\n```\n"
    if verb.epilog:
        yield verb.epilog.replace("Example: ", "Example: `") + "`\n"
    if arguments or options:
        yield "| | |\n|---|---|"
    for parameter in arguments:
        yield f"| {_cell(parameter.metavar)} | {_cell(parameter.help)} |"
    for option in options:
        record = option.get_help_record(context)
        if record is not None:
            flags, text = record
            code = f"<code>{_escaped(flags)}</code>"
            yield f"| {code} | {_cell(text)} |"
    yield ""


def _cell(text: str) -> str:
    return " ".join(_escaped(text).split())


def _escaped(text: str) -> str:
    return text.replace("<", "&lt;").replace(">", "&gt;").replace("|", "&#124;")
