"""The page about the report has every section of a report, and no other."""

import ast
import re

from pages import ROOT

from orbident.estimation.checks import VERDICTS

PAGE = (ROOT / "docs/reading-the-report.md").read_text(encoding="utf-8")
REPORT = ROOT / "src/orbident/report"
OTHER_PAGES = {"allan.py", "campaign_page.py", "study_page.py"}
"""Modules of reports about a recording at rest, a campaign and a study."""


def titles(text: str) -> set[str]:
    """Titles of the sections that a module makes."""
    found = set[str]()
    for node in ast.walk(ast.parse(text)):
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "Section"
        ):
            named = {keyword.arg: keyword.value for keyword in node.keywords}
            found.add(ast.literal_eval(named.get("title") or node.args[1]))
    return found


def test_every_section_is_explained():
    modules = (path for path in REPORT.glob("*.py") if path.name not in OTHER_PAGES)
    made = set().union(*(titles(path.read_text()) for path in modules))
    assert len(made) > 10
    assert set(re.findall(r"^### `(.*)`$", PAGE, re.MULTILINE)) == made


def test_the_verdicts_are_those_of_the_report():
    rows = re.findall(r"^\| (.*?) \| `(.*?)` \|", PAGE, re.MULTILINE)
    found = {level: words.lower() for words, level in rows if level in VERDICTS}
    assert found == VERDICTS
