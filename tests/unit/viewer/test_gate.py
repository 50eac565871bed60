"""The gate: pages of the viewer's own address pass, all others are refused."""

import http.client
import logging
import socket
from collections.abc import Iterator
from contextlib import closing, nullcontext
from threading import Event
from typing import Any

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from orbident.viewer.server import Gate, Served, close, open_server

EVIL = "evil.example"


def status(served: Served, path: str = "/", **headers: str | None) -> int:
    """Status of a plain request; `Host` is the right one where it is not given."""
    port = served.server.get_port()
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    with closing(connection):
        connection.putrequest("GET", path, skip_host=True)
        for name, value in ({"Host": f"127.0.0.1:{port}"} | headers).items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders()
        with connection.getresponse() as answer:
            return answer.status


def joined(served: Served, host: str, origin: str | None, path: str = "/") -> bool:
    """Whether a websocket is opened, and the scene sent."""
    port = served.server.get_port()
    protocol: Any = f"viser-v{viser.__version__}"
    try:
        with connect(
            f"ws://{host}{path}",
            sock=socket.create_connection(("127.0.0.1", port)),
            origin=origin,  # pyright: ignore[reportArgumentType]: a plain text
            subprotocols=[protocol],
            open_timeout=10,
        ) as opened:
            return len(opened.recv(timeout=10)) > 0
    except InvalidStatus as refused:
        return refused.response.status_code != 403


def here(served: Served) -> str:
    return f"127.0.0.1:{served.server.get_port()}"


def test_the_page_is_for_names_of_this_machine_only(served: Served):
    port = served.server.get_port()
    for host in ("127.0.0.1", "localhost", "LocalHost", "[::1]"):
        assert status(served, Host=f"{host}:{port}") == 200
    for host in (
        EVIL,
        f"{EVIL}:{port}",
        "127.0.0.1",
        f"127.0.0.1:{port + 1}",
        f"127.0.0.1.{EVIL}:{port}",
        f"localhost:{port}.{EVIL}",
        "",
        None,
    ):
        assert status(served, Host=host) in {400, 403}, host


def test_a_foreign_page_cannot_fetch_it(served: Served):
    assert status(served, Origin=f"http://{here(served)}") == 200
    for origin in (f"http://{EVIL}", "null", f"https://{here(served)}"):
        assert status(served, Origin=origin) == 403


def test_only_its_own_page_opens_a_websocket(served: Served):
    port, own = served.server.get_port(), here(served)
    assert joined(served, own, f"http://{own}")
    assert joined(served, f"localhost:{port}", f"http://localhost:{port}")
    for origin in (
        f"http://{EVIL}",
        "null",
        None,
        f"http://127.0.0.1:{port + 1}",
        f"http://localhost:{port}",
        f"http://{own}.{EVIL}",
    ):
        assert not joined(served, own, origin), origin
    # A name of a stranger that was made to lead here (DNS rebinding).
    assert not joined(served, f"{EVIL}:{port}", f"http://{EVIL}:{port}")


def test_no_other_page_may_hold_it_or_lead_it_elsewhere(served: Served):
    connection = http.client.HTTPConnection(here(served), timeout=10)
    with closing(connection):
        connection.request("GET", "/")
        with connection.getresponse() as answer:
            headers = answer.headers
    policy = headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in policy
    assert f"connect-src 'self' ws://{here(served)} data: blob:;" in policy
    assert headers["X-Frame-Options"] == "DENY"


@pytest.fixture
def open_to_all() -> Iterator[Served]:
    served = open_server("0.0.0.0", 0)
    yield served
    close(served.server)


def test_an_open_viewer_asks_for_its_token(open_to_all: Served):
    own = f"some.name:{open_to_all.server.get_port()}"
    path = f"/{open_to_all.url.split('/')[3]}"
    wrong = path[:-1] + ("a" if path[-1] != "a" else "b")
    for right in (path, f"{path}/", f"{path}/?darkMode", f"{path}?darkMode"):
        assert status(open_to_all, right, Host=own) == 200
    assert status(open_to_all, f"{path}/nothing", Host=own) == 404
    for refused in ("/", wrong, f"{path}x", f"/x{path}", f"/?{path[1:]}", "/%ff"):
        assert status(open_to_all, refused, Host=own) == 403, refused
    assert joined(open_to_all, own, f"http://{own}", path)
    assert not joined(open_to_all, own, f"http://{own}", wrong)
    assert not joined(open_to_all, own, f"http://{own}")
    # The token alone does not let another page in.
    assert not joined(open_to_all, own, f"http://{EVIL}", path)


@pytest.mark.parametrize(
    ("host", "bound", "names"),
    [
        ("127.0.0.1", "127.0.0.1", {"127.0.0.1", "localhost", "[::1]"}),
        ("Mine", "127.0.1.1", {"mine", "127.0.1.1", "127.0.0.1", "localhost", "[::1]"}),
        ("::1", "::1", {"127.0.0.1", "localhost", "[::1]"}),
        ("192.0.2.1", "192.0.2.1", {"192.0.2.1"}),
        ("0", "0.0.0.0", set()),
        ("::", "::", set()),
    ],
)
def test_names_and_token_follow_from_the_address(
    host: str, bound: str, names: set[str]
):
    gate = Gate.at(host, bound)
    assert gate.names == names
    assert gate.is_open == (not bound.startswith("127.") and bound != "::1")
    assert gate.token != Gate.at(host, bound).token or not gate.is_open


def test_every_open_viewer_has_its_own_token():
    assert len({Gate.at("0.0.0.0", "0.0.0.0").token for _ in range(100)}) == 100


def test_the_port_of_plain_http_is_left_out():
    gate = Gate.at("127.0.0.1", "127.0.0.1")
    for host in ("localhost", "[::1]", "localhost:80"):
        assert gate.admits(80, [host], [], plain=True)
    assert not gate.admits(8080, ["localhost"], [], plain=True)


def test_a_header_that_stands_twice_is_refused():
    """Which of the two another program would believe is not known."""
    gate = Gate.at("127.0.0.1", "127.0.0.1")
    own = "http://localhost"
    assert gate.admits(80, ["localhost"], [own], plain=False)
    assert not gate.admits(80, ["localhost", "localhost"], [own], plain=False)
    assert not gate.admits(80, ["localhost"], [own, own], plain=False)
    assert not gate.admits(80, ["localhost"], [own, f"http://{EVIL}"], plain=True)


GARBAGE = (
    "a text",
    b"",
    b"\xc1",
    b"\xff" * 1000,
    msgspec.msgpack.encode(7),
    msgspec.msgpack.encode({"no": "type"}),
    msgspec.msgpack.encode({"type": "Nonsense"}),
    msgspec.msgpack.encode({"type": "GuiUpdateMessage"}),
    msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": 1, "updates": 2}),
    msgspec.msgpack.encode({"type": "ViewerCameraMessage", "wxyz": "x"}),
)


def test_garbage_leaves_no_word(
    served: Served, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
):
    own = here(served)
    protocol: Any = f"viser-v{viser.__version__}"
    slider = served.server.gui.add_slider("s", 0.0, 1.0, 0.1, 0.0)
    bad_values = [
        {"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates}
        for uuid in served.server.gui._gui_input_handle_from_uuid
        for updates in ({"value": "x"}, {"value": None}, {"nonsense": 1}, {"value": []})
    ]
    assert slider.value == 0.0
    for message in (*GARBAGE, *map(msgspec.msgpack.encode, bad_values)):
        with connect(
            f"ws://{own}",
            origin=f"http://{own}",  # pyright: ignore[reportArgumentType]
            subprotocols=[protocol],
        ) as opened:
            opened.send(message)
            try:
                while True:
                    opened.recv(timeout=0.1)
            except (ConnectionClosed, TimeoutError):
                pass
    for raw in (b"\0\xff\r\n\r\n", b"POST / HTTP/1.1\r\nHost: x\r\n\r\n", b""):
        address = ("127.0.0.1", served.server.get_port())
        with socket.create_connection(address) as plain:
            plain.sendall(raw)
    assert status(served) == 200
    assert slider.value == 0.0
    close(served.server)
    assert capfd.readouterr() == ("", "")
    assert [r for r in caplog.records if r.levelno >= logging.WARNING] == []


def test_a_viser_that_serves_past_the_gate_is_not_used(
    monkeypatch: pytest.MonkeyPatch,
):
    ignored = nullcontext(Event())
    monkeypatch.setattr("orbident.viewer.server.gated", lambda gate: ignored)
    with pytest.raises(RuntimeError, match="past the gate"):
        open_server("127.0.0.1", 0)
