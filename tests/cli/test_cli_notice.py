"""The word on a terminal while a verb loads its libraries."""

import os

import pytest
from processes import started


def on_a_terminal(*words: str) -> bytes:
    """All that a terminal is sent."""
    pty = pytest.importorskip("pty", reason="Windows has no pseudo-terminals")
    ours, theirs = pty.openpty()
    sent = b""
    with started(*words, stdout=theirs, stderr=theirs):
        os.close(theirs)
        # Linux ends the reading of a terminal that nobody writes to with an error.
        try:
            while part := os.read(ours, 4096):
                sent += part
        except OSError:
            pass
    os.close(ours)
    return sent


@pytest.mark.parametrize(
    ("words", "said"),
    [(("robots",), b"3 robots come with"), (("inspect", "no.yaml"), b"orbident: no.y")],
)
def test_it_stands_there_until_there_is_more_to_say(
    words: tuple[str, ...], said: bytes
):
    notice = f"orbident {words[0]}: working ...".encode()
    sent = on_a_terminal(*words)
    assert sent.startswith(notice + b"\r" + b" " * len(notice) + b"\r" + said)
    assert sent.count(notice) == 1


def test_help_needs_none():
    assert on_a_terminal("identify", "-h").startswith(b"Usage: orbident identify")
