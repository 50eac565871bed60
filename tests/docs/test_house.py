"""The house: how large it may be, and that no name is given twice."""

import ast
from collections import defaultdict
from functools import cache
from pathlib import Path

from pages import ROOT

PACKAGE = ROOT / "src/orbident"

# These only go down. Who must raise one says why in CHANGELOG.md.
MOST = {
    "files": 309,
    "lines": 65_409,
    "files of estimation": 57,
    "lines of estimation": 13_615,
    "files with one user": 63,
    "imports below each other": 31,
    "numbers without a reason": 38,
}


@cache
def trees() -> dict[str, ast.Module]:
    """Every module and what stands in it."""
    return {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): ast.parse(
            path.read_text()
        )
        for path in PACKAGE.rglob("*.py")
    }


@cache
def imported(name: str) -> set[str]:
    """The modules that a module imports when it is imported itself."""
    nodes = [n for n in trees()[name].body if isinstance(n, ast.ImportFrom)]
    named = {n.module or "" for n in nodes}
    named |= {f"{n.module}.{alias.name}" for n in nodes for alias in n.names}
    return named & trees().keys()


@cache
def depth(name: str) -> int:
    return 1 + max(map(depth, imported(name)), default=0)


def with_one_user() -> int:
    users = defaultdict[str, int](int)
    for name in trees():
        for below in imported(name):
            users[below] += 1
    return sum(number == 1 for number in users.values())


def without_a_reason(name: str) -> int:
    """Numbers of a module that have neither a sentence below nor a comment above."""
    path = PACKAGE.parent / Path(*name.split(".")).with_suffix(".py")
    lines, body = path.read_text().splitlines(), trees()[name].body
    bare = 0
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)):
            continue
        number = isinstance(node.value, ast.Constant | ast.UnaryOp | ast.BinOp)
        if isinstance(node.value, ast.Constant):
            number = isinstance(node.value.value, int | float)
        said = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        said |= "#" in lines[node.lineno - 1] or "#" in lines[node.lineno - 2]
        bare += number and not said
    return bare


def test_the_house_does_not_grow():
    lines = {path: len(path.read_text().splitlines()) for path in PACKAGE.rglob("*.py")}
    estimation = [n for path, n in lines.items() if "estimation" in path.parts]
    found = {
        "files": len(lines),
        "lines": sum(lines.values()),
        "files of estimation": len(estimation),
        "lines of estimation": sum(estimation),
        "files with one user": with_one_user(),
        "imports below each other": max(map(depth, trees())),
        "numbers without a reason": sum(map(without_a_reason, trees())),
    }
    grown = {name: each for name, each in found.items() if each > MOST[name]}
    assert grown == {}


def test_every_name_is_given_once():
    """A verb may have the name of the function and of the file that do its work."""
    files, names = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
    for name, tree in trees().items():
        if name.startswith("orbident.cli.") or name.endswith("__init__"):
            continue
        files[name.rpartition(".")[2]].append(name)
        for node in tree.body:
            if not isinstance(node, ast.ClassDef | ast.FunctionDef):
                continue
            if isinstance(node, ast.ClassDef) or not node.name.startswith("_"):
                names[node.name].append(name)
    for given in (files, names):
        assert {n: places for n, places in given.items() if len(places) > 1} == {}
