"""What the page of equations leads to names these equations itself."""

import inspect
import re
from pkgutil import resolve_name

import pytest
from pages import ROOT

PAGE = (ROOT / "docs/equations.md").read_text(encoding="utf-8")
CORE = ROOT / "src/core/include/orbident"
NUMBER = r"(?:A\.)?\d+"
LIST = rf"{NUMBER}(?:(?:, | and | to |-){NUMBER})*"
NAMED = re.compile(rf"(?:Eqs?\. |\((?=A\.))({LIST})")
ROWS = re.findall(rf"^\| ({LIST}) \|(.*)$", PAGE, re.MULTILINE)
LAST = 47
"""The paper's last equation before its appendix."""


def numbers(text: str) -> set[str]:
    """Every number of a list, with those that `9 to 13` or `9-13` leaves out."""
    found = set(re.findall(NUMBER, text))
    for first, last in re.findall(r"(\d+)(?: to |-)(\d+)", text):
        found |= {str(k) for k in range(int(first), int(last) + 1)}
    return found


def named_in(text: str) -> set[str]:
    """The equations that a text names."""
    words = " ".join(text.replace("//", "").split())
    return set().union(*map(numbers, NAMED.findall(words)))


@pytest.mark.parametrize(("equations", "row"), ROWS, ids=[row[0] for row in ROWS])
def test_the_code_of_an_equation_names_it(equations: str, row: str):
    _, *places = row.split("|")
    names = re.findall(r"`([^`]+)`", "".join(places))
    assert names
    for name in names:
        text = (
            (CORE / name).read_text(encoding="utf-8")
            if name.endswith(".hpp")
            else inspect.getdoc(resolve_name(f"orbident.{name}")) or ""
        )
        assert numbers(equations) <= named_in(text), name


def test_no_equation_is_left_out():
    without = re.search(r"have no code:(.*?)no special case", PAGE, re.DOTALL)
    assert without is not None
    found = {number for equations, _ in ROWS for number in numbers(equations)}
    assert {str(k) for k in range(1, LAST + 1)} <= found | numbers(without[1])
