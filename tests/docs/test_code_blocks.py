"""Every block of the README and of the site runs, and prints what is said there."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jaxtyping
import pytest
import typer
from pages import PAGES, Block, blocks, commands, name_of
from printed import is_printed
from readers_files import BEFORE, finished_map

from orbident.cli.app import main
from orbident.cli.verbs import app

RUNNING = [
    page for page in PAGES if any(b.language in {"python", "sh"} for b in blocks(page))
]
SHOWN = {
    "view": "serves a page until Ctrl-C",
    "--view": "the same",
    "--seeds": "takes minutes",
    "planar": "takes eight seconds, and tests of its own run it",
    "table": "takes ten seconds, and tests of its own run it",
    "campaign.yaml": "takes hours",
    "thousands": "is what that leaves",
    "table.yaml": "is a robot that none of these recordings is of",
}
"""Words of commands that are not run; these must be right all the same."""

INSTEAD = {"make demo": ["orbident", "demo", "--force"]}
"""What a command that is not ours ends with."""

AFTER = {"orbident topics table.bag -o map.yaml": finished_map}
"""What the reader does after a command."""


DEAR = {
    "README.md",
    *("docs/first-result.md", "docs/gallery.md", "docs/installation.md"),
    *("docs/paper-studies.md", "docs/skill/SKILL.md", "docs/how-to/thrusters.md"),
    *("docs/how-to/designing-an-excitation.md", "docs/how-to/campaigns.md"),
    *("docs/how-to/what-acts-from-outside.md", "docs/how-to/several-recordings.md"),
    "docs/how-to/laboratory-checklist.md",
}
"""Pages whose commands take five seconds or more."""


def paged(page: Path):
    marks = [pytest.mark.slow] if name_of(page) in DEAR else []
    return pytest.param(page, id=name_of(page), marks=marks)


def test_dear_pages_are_there():
    assert {*map(name_of, RUNNING)} >= DEAR


@pytest.mark.parametrize("page", [*map(paged, RUNNING)])
def test_the_page_runs(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    # As installed: in tests a wrong shape is refused before the command can see it.
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)
    BEFORE.get(name_of(page), lambda: None)()
    names = {"__name__": "__main__"}
    for block, shown in with_what_is_shown(page):
        where = f"{page}:{block.line}"
        if block.title:
            (tmp_path / block.title).write_text(block.text)
        elif block.language == "python":
            code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
            exec(code, names)
        elif block.language == "sh":
            capsys.readouterr()
            ran = [words for words in commands(block) if is_run(words)]
            statuses = [run(words, monkeypatch) for words in ran]
            printed = "\n".join(capsys.readouterr())
            # What is refused is shown as what the command says.
            said = shown.startswith("orbident: ")
            assert said or not any(statuses), f"{where}: {statuses}: {printed}"
            if ran:
                assert is_printed(shown, printed), f"{where} prints:\n{printed}"


def with_what_is_shown(page: Path) -> Iterator[tuple[Block, str]]:
    """Each block, with the text of the next one if that is `text`."""
    every = blocks(page)
    for block, after in zip(every, [*every[1:], None], strict=True):
        yield block, after.text if after and after.language == "text" else ""


def is_run(words: list[str]) -> bool:
    if " ".join(words) in INSTEAD:
        return True
    if words[0] != "orbident":
        return False
    check(words[1:])
    return not SHOWN.keys() & set(words)


def run(words: list[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run one command in this process; its status. A search is cut short."""
    line = " ".join(words)
    hasty = ["--budget", "1"] if words[1] == "excite" else []
    monkeypatch.setattr(sys, "argv", [*INSTEAD.get(line, words), *hasty])
    with pytest.raises(SystemExit) as ended:
        main()
    AFTER.get(line, lambda: None)()
    return ended.value.code


def check(words: list[str]) -> None:
    """Whether the command knows this verb, its options, and as many arguments."""
    group: Any = typer.main.get_command(app)
    with group.make_context("orbident", list(words)) as context:
        name, verb, rest = group.resolve_command(context, words)
        verb.make_context(name, rest, parent=context)
