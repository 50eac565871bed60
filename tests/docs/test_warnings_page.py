"""The page of warnings has every check of the source, and no other."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from pages import ROOT

JUDGES = [ROOT / "src/orbident" / name for name in ("estimation", "diagnosis", "noise")]
MAKERS = {"Check", "_refused"}


def template(node: ast.expr) -> str | None:
    """A name; what is filled in is `...`."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        parts = (p.value if isinstance(p, ast.Constant) else "..." for p in node.values)
        return "".join(map(str, parts))
    return None


def assigned(tree: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Names and what they stand for, also side by side."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = list(zip(target.elts, node.value.elts, strict=True))
            for name, value in pairs:
                if isinstance(name, ast.Name):
                    yield name.id, value


def checks_of(path: Path) -> Iterator[str]:
    tree = ast.parse(path.read_text())
    known = {
        name: text
        for name, value in assigned(tree)
        if (text := template(value)) is not None
    }
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in MAKERS
        ):
            name = node.args[0]
            text = known.get(name.id) if isinstance(name, ast.Name) else template(name)
            # What is None is the argument of a maker.
            if text is not None:
                yield text


def test_every_check_is_explained():
    page = (ROOT / "docs/warnings.md").read_text(encoding="utf-8")
    explained = re.findall(r"^### `(.*)`$", page, re.MULTILINE)
    paths = (path for folder in JUDGES for path in folder.rglob("*.py"))
    found = {name for path in paths for name in checks_of(path)}
    assert len(found) > 20
    assert sorted(explained) == sorted(found)
