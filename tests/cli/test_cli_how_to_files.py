"""The how-to page on files of other tools: what it says is printed is printed."""

import re
from pathlib import Path

from running import Orbident

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "files-of-other-tools.md"


def blocks(language: str) -> list[str]:
    pattern = rf"```{language}[^\n]*\n(.*?)```"
    return re.findall(pattern, PAGE.read_text(), re.DOTALL)


def test_the_page(orbident: Orbident):
    (script,), (finished,) = blocks("python"), blocks("yaml")
    exec(compile(script, str(PAGE), "exec"), {})
    Path("map.yaml").write_text(finished)
    for command, printed in zip(blocks("bash"), blocks("text"), strict=False):
        verb, *arguments = command.split()
        assert verb == "orbident"
        assert orbident(*arguments).done().out == printed
