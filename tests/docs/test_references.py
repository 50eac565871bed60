"""What pages say of the source is there: files, decisions and their numbers."""

import re
from pathlib import Path

import pytest
from pages import PAGES, ROOT, name_of

ALL = (*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "benchmarks/README.md")
SOURCES = ("", "src/orbident/", "src/core/include/orbident/", "benchmarks/")
"""Where a file may be that a page names."""

FILE = re.compile(r"`([\w/.-]+\.(?:py|hpp))`")
HOUSE = re.compile(r"^```text\nsrc/core/\n(.*?)^```$", re.MULTILINE | re.DOTALL)
DECISIONS = sorted((ROOT / "docs/decisions").glob("*.md"))


@pytest.mark.parametrize("page", ALL, ids=name_of)
def test_the_files_that_a_page_names_are_there(page: Path):
    for name in FILE.findall(page.read_text(encoding="utf-8")):
        assert any((ROOT / folder / name).is_file() for folder in SOURCES), name


def test_a_decision_has_the_number_of_its_file_and_no_other_has_it():
    numbers = [int(note.name[:4]) for note in DECISIONS]
    assert len(set(numbers)) == len(numbers)
    for note, number in zip(DECISIONS, numbers, strict=True):
        assert note.read_text(encoding="utf-8").startswith(f"# {number}. "), note.name


@pytest.mark.parametrize("page", [*ALL, ROOT / "CHANGELOG.md"], ids=name_of)
def test_the_decisions_that_a_page_refers_to_are_there(page: Path):
    numbers = {int(note.name[:4]) for note in DECISIONS}
    for number in re.findall(r"[Dd]ecision (\d+)", page.read_text(encoding="utf-8")):
        assert int(number) in numbers


def test_the_house_has_every_package_and_every_header():
    found = HOUSE.search((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
    assert found is not None
    house = set(re.findall(r"[\w.]+", found[1]))
    packages = {path.parent.name for path in ROOT.glob("src/orbident/*/__init__.py")}
    modules = {path.name for path in ROOT.glob("src/orbident/[!_]*.py")}
    headers = {path.stem for path in ROOT.glob("src/core/include/orbident/*.hpp")}
    assert packages | modules | headers <= house
