"""The notebook runs from its first cell to its last, and is kept without outputs."""

import json
from pathlib import Path
from typing import Any

import jaxtyping
import pytest
from pages import ROOT

NOTEBOOKS = sorted((ROOT / "docs").rglob("*.ipynb"))


def cells(notebook: Path) -> list[dict[str, Any]]:
    document = json.loads(notebook.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4
    return document["cells"]


def test_there_is_one():
    assert [notebook.name for notebook in NOTEBOOKS] == ["tutorial.ipynb"]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.name)
def test_it_has_no_outputs(notebook: Path):
    for cell in cells(notebook):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.name)
def test_it_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    # As installed: in tests a wrong shape is refused before the command can see it.
    monkeypatch.setattr(jaxtyping.config, "jaxtyping_disable", True)
    names: dict[str, Any] = {"__name__": "__main__"}
    for cell in cells(notebook):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    # What its text says of what it finds: a robot that is 8 % heavier, and known so.
    result = names["result"]
    assert result.level == "trust"
    off = result.mass.value / names["cad"].mass - 1.08
    assert abs(off * names["cad"].mass) < 4 * result.mass.std
