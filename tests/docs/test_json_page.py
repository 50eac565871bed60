"""The page of files has every schema of the source, and every key of a result."""

import json
import re
from pathlib import Path

from made_results import exact_result
from pages import ROOT

import orbident as oi

PAGE = (ROOT / "docs/json-files.md").read_text(encoding="utf-8")
PACKAGE = ROOT / "src/orbident"
SCHEMA = r"orbident/[a-z-]+/\d+"


def test_every_schema_is_there_with_the_file_that_has_its_types():
    rows = dict(re.findall(rf"^\| `({SCHEMA})` .*\| `([\w/.]+)` \|$", PAGE, re.M))
    sources = {path: path.read_text() for path in PACKAGE.rglob("*.py")}
    assert set(rows) == set(re.findall(SCHEMA, "".join(sources.values())))
    for schema, file in rows.items():
        assert schema in sources[PACKAGE / file]


def test_every_key_of_a_result_is_there(tmp_path: Path):
    oi.save_result(exact_result(oi.load_robot("paper-spatial")), tmp_path / "run")
    written = json.loads((tmp_path / "run/result.json").read_text())
    table = PAGE[PAGE.index("## A result") :]
    first = "".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE))
    assert sorted(re.findall(r"`(\w+)`", first)) == sorted(written)
