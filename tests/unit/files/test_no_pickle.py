"""No file that a user is given can run a program: nothing is ever unpickled."""

import ast
from pathlib import Path

import pytest

import orbident

UNPICKLING = frozenset(
    {"pickle", "_pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal"}
    | {"shelve"}
)
READS = "read_"
"""pandas reads pickles, and other files that hold them; a table may be given to it."""
SOURCES = sorted(Path(orbident.__file__).parent.rglob("*.py"))


def imported(tree: ast.AST) -> set[str]:
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    return {name.partition(".")[0] for name in names}


def unpickles(source: str) -> bool:
    """Whether a module imports what unpickles, or has NumPy do so."""
    tree = ast.parse(source)
    # Refused in so many words is as good as not asked for; anything else might be true.
    allowed = any(
        node.arg == "allow_pickle" and ast.unparse(node.value) != "False"
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword)
    )
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    reads = "pandas" in imported(tree) and any(READS in node.attr for node in nodes)
    return bool(imported(tree) & UNPICKLING) or allowed or reads


def test_nothing_is_unpickled():
    # Else the package was not found, and the test would say nothing.
    assert len(SOURCES) > 100
    found = [path for path in SOURCES if unpickles(path.read_text(encoding="utf-8"))]
    assert found == []


@pytest.mark.parametrize(
    "source",
    [
        "import pickle",
        "import os, marshal as m",
        "from shelve import open",
        "def f():\n    from joblib.memory import x",
        "np.load(path, allow_pickle=True)",
        "np.load(path, allow_pickle=flag)",
        "import pandas\npandas.read_csv(path)",
    ],
)
def test_it_would_be_seen(source: str):
    assert unpickles(source)
