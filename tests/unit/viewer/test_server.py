"""The server says what is wrong with where it is to listen."""

import socket
import sys
import urllib.request
from typing import Any

import pytest

from orbident.errors import InputError
from orbident.viewer.server import Served, close, keep_moving, open_server


def test_it_serves_a_page_here_only(served: Served, capsys: pytest.CaptureFixture[str]):
    assert served.url == f"http://127.0.0.1:{served.server.get_port()}/"
    assert not served.is_open
    with urllib.request.urlopen(served.url, timeout=60) as answer:
        assert b"<html" in answer.read(1000)
    # Standard output is for results.
    assert capsys.readouterr().out == ""


def test_a_taken_port_is_refused(server: Any):
    with pytest.raises(InputError, match=r"--port: \d+ at 127.0.0.1 cannot be used"):
        open_server("127.0.0.1", server.get_port())


@pytest.mark.parametrize("host", ["no such host", "999.1.1.1", "192.0.2.1", "x" * 300])
def test_a_host_that_is_not_here_is_refused(host: str):
    with pytest.raises(InputError, match="--host"):
        open_server(host, 0)


def test_everywhere_is_shown_under_the_name_of_this_machine():
    served = open_server("0.0.0.0", 0)
    try:
        assert served.is_open
        start = f"http://{socket.gethostname()}:{served.server.get_port()}/"
        token = served.url.removeprefix(start)
        # 16 bytes in base 64, and a slash.
        assert len(token) == 23
    finally:
        close(served.server)


def test_without_viser_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r'needs viser: .* "orbident\[view\]"'):
        open_server("127.0.0.1", 0)


def test_an_interrupt_ends_the_movement():
    told = []

    class Once:
        def advance(self, seconds: float) -> None:
            told.append(seconds)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        keep_moving(Once())
    assert len(told) == 1


def test_it_closes_quietly(capsys: pytest.CaptureFixture[str]):
    server, url, _ = open_server("127.0.0.1", 0)
    close(server)
    assert capsys.readouterr() == ("", "")
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(url, timeout=60)
