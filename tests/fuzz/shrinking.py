"""A smaller case that still fails in the same way."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeVar

from case import Case

MOST_RUNS = 200
"""How often the command may run for one case."""
TEXT = 50_000
"""Bytes: longer files are shortened by halves, not line by line."""

Fails = Callable[[Case], bool]
Sequence_ = TypeVar("Sequence_", bytes, tuple)


def shrunk(case: Case, fails: Fails, runs: int = MOST_RUNS) -> Case:
    """Fewer arguments, files and bytes, as long as it fails.

    Args:
        case: that fails.
        fails: whether a smaller one fails in the same way.
        runs: how often that may be asked.
    """
    progress = True
    while progress and runs > 0:
        progress = False
        for smaller in _smaller(case):
            runs -= 1
            if fails(smaller):
                case, progress = smaller, True
                break
            if runs <= 0:
                break
    return case


def _smaller(case: Case) -> Iterator[Case]:
    for name in case.files:
        rest = {key: value for key, value in case.files.items() if key != name}
        yield replace(case, files=rest)
    for count in (2, 1):
        for k in range(1, len(case.arguments) - count + 1):
            kept = case.arguments[:k] + case.arguments[k + count :]
            yield replace(case, arguments=kept)
    for name, content in case.files.items():
        for shorter in _shorter(content):
            yield replace(case, files={**case.files, name: shorter})


def _shorter(content: bytes) -> Iterator[bytes]:
    lines = content.splitlines(keepends=True)
    if len(lines) > 1:
        yield from (b"".join(rest) for rest in _without_a_part(tuple(lines)))
    elif len(content) <= TEXT:
        yield from _without_a_part(content)


def _without_a_part(whole: Sequence_) -> Iterator[Sequence_]:
    """Without its halves, quarters, eighths and so on."""
    size = len(whole) // 2
    while size:
        for start in range(0, len(whole), size):
            yield whole[:start] + whole[start + size :]
        size //= 2
