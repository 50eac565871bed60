"""Help that is whole sentences with an example, and completion by a shell."""

import shlex
from typing import cast

import pytest
import typer
from running import Orbident
from typer.core import TyperGroup

from orbident.cli.verbs import EXAMPLES, app

GROUP = cast("TyperGroup", typer.main.get_command(app))
CAMPAIGN = cast("TyperGroup", GROUP.commands["campaign"])
VERBS = {**GROUP.commands, **{f"campaign {k}": v for k, v in CAMPAIGN.commands.items()}}


@pytest.mark.parametrize("name", VERBS)
def test_help_is_whole_sentences(name: str):
    """As a reader sees it: nothing is cut short, nothing begins in the middle."""
    verb = VERBS[name]
    assert verb.help
    assert verb.get_short_help_str(limit=66) == verb.help.split("\n")[0]
    for each in (verb, *verb.params):
        words = getattr(each, "help", "") or ""
        assert words.endswith("."), each.name
        assert not words.startswith(("Of ", "By ", "Instead ", "Also ")), words


@pytest.mark.parametrize("name", VERBS)
def test_the_example_could_be_run(name: str):
    verb = VERBS[name]
    assert verb.epilog is not None
    assert verb.epilog.startswith(f"Example: orbident {name} ".rstrip())
    words = shlex.split(verb.epilog)[2 + len(name.split()) :]
    with GROUP.make_context("orbident", [name]) as context:
        verb.make_context(name, words, parent=context)


def test_examples_are_of_every_verb():
    assert [verb.__name__ for verb in EXAMPLES] == list(GROUP.commands)[:-1]


@pytest.mark.parametrize("words", [(), ("identify",), ("campaign",)])
def test_h_is_help(orbident: Orbident, words: tuple[str, ...]):
    assert orbident(*words, "-h").done() == orbident(*words, "--help").done()


COMPLETED: list[tuple[str, list[str]]] = [
    ("orbident identi", ["identify"]),
    ("orbident identify --disturb", ["--disturbance"]),
    ("orbident identify cep", ["cepheus-like"]),
    ("orbident identify --method s", ["structured"]),
    ("orbident convert log.ulg --preset px", ["px4-spacecraft"]),
    ("orbident identify paper-spatial fli", []),
]


@pytest.mark.parametrize(("typed", "wanted"), COMPLETED)
def test_bash_completes(
    orbident: Orbident, monkeypatch: pytest.MonkeyPatch, typed: str, wanted: list[str]
):
    """Where nothing is found, bash goes on with the names of files."""
    monkeypatch.setenv("_ORBIDENT_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", str(len(typed.split()) - 1))
    assert orbident().out.split() == wanted
