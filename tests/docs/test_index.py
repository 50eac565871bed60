"""The first page of the site leads to every other page."""

import re
from collections.abc import Iterator

import yaml
from pages import ROOT


def pages_of(nav: list | str) -> Iterator[str]:
    """Every page of a navigation, or of a section of one, with titles left out."""
    if isinstance(nav, str):
        yield nav
        return
    for entry in nav:
        for section in entry.values():
            yield from pages_of(section)


def test_every_page_of_the_navigation_is_linked_from_the_index():
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"]
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    linked = set(re.findall(r"\]\(([^)#]+)", index))
    assert set(pages_of(nav)) - {"index.md"} <= linked
