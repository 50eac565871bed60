"""No test waits for a process for ever, whatever it is started under."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
WAITING = {"wait", "communicate", "urlopen"}
"""Calls that wait for processes and servers."""
STARTING = {"processes.py", "watcher.py"}
"""What may start processes: the one limits how long a command may take; the other, of
the fuzzer, watches time and memory of a worker that runs thousands of commands."""


@pytest.mark.parametrize(
    "path", sorted(TESTS.rglob("*.py")), ids=lambda path: str(path.relative_to(TESTS))
)
def test_whatever_waits_has_a_limit(path: Path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        given = {keyword.arg for keyword in node.keywords}
        called = f"{path.name}:{node.lineno}: {ast.unparse(node.func)}"
        if node.func.attr in WAITING:
            # An event's `wait` takes its limit as the one argument.
            assert "timeout" in given or (node.func.attr == "wait" and node.args), (
                called
            )
        if ast.unparse(node.func).startswith("subprocess."):
            assert path.name in STARTING, f"{called}: use tests/support/processes.py"
