"""The blocks of a page, and how each is run.

python                     run, in one namespace a page
sh                         run: commands of orbident, but for those in `SHOWN`
text                       after sh: what its commands print
LANGUAGE title="FILE"      written to that file
anything else              shown only
"""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
BLOCK = re.compile(r"^```(\w+)[ ]?(.*?)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    language: str
    title: str
    text: str
    line: int
    """Number of the text's first line in the page."""


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path) -> list[Block]:
    """All blocks of a page that name their language."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(
            language=found[1],
            title=found[2].removeprefix("title=").strip('"'),
            text=found[3],
            line=text.count("\n", 0, found.start()) + 2,
        )
        for found in BLOCK.finditer(text)
    ]


def commands(block: Block) -> Iterator[list[str]]:
    """The words of every command, comments apart."""
    for line in block.text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield words
