"""A word on the terminal until a verb has more to say: loading takes a second."""

import sys

_shown = ""


def show_at_work(verb: str) -> None:
    """Say that the verb is at work; nothing where standard error is no terminal."""
    global _shown
    if sys.stderr.isatty():
        _shown = f"orbident {verb}: working ..."
        print(_shown, end="\r", file=sys.stderr, flush=True)


def wipe() -> None:
    """Make room for what the verb says."""
    global _shown
    if _shown:
        print(" " * len(_shown), end="\r", file=sys.stderr, flush=True)
        _shown = ""
