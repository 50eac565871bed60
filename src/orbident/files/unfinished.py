"""What is undone where a process ends while it writes.

A block that fails undoes it by itself. A thread that ends the process does not wait for
that: it undoes what is unfinished, and nothing new appears, nor is anything finished,
from then on.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

CHANGING = threading.RLock()
"""Held while something temporary appears or becomes final, not while it is filled."""
_PATIENCE = 0.3
"""What such a moment may take before the process ends all the same, s."""
_UNDO: list[Callable[[], None]] = []


@contextmanager
def undone(undo: Callable[[], None]) -> Iterator[None]:
    """Call `undo` if the block fails, or if another thread ends the process during it.

    Args:
        undo: may be called twice, and by that thread.
    """
    _UNDO.append(undo)
    try:
        yield
    except BaseException:
        undo()
        raise
    finally:
        _UNDO.remove(undo)


def undo_all() -> None:
    """Undo what is unfinished; the process must end next."""
    CHANGING.acquire(timeout=_PATIENCE)
    for undo in tuple(_UNDO):
        undo()
