"""Another page in the same browser can neither read the viewer nor hold it."""

import http.server
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
import viser
from chromium import chromium
from selenium.webdriver.common.by import By

from orbident.viewer.server import Served, close, open_server
from orbident.viewer.stage import heading

PATIENCE = 60.0
"""Seconds; a shared processor draws instead of a graphics card."""
TITLE = "what only our own page may read"

CONNECT = """
const [address, protocol, done] = arguments;
const socket = new WebSocket(address, protocol);
socket.onmessage = () => done("read");
socket.onerror = () => done("refused");
"""
FETCH = """
const [address, done] = arguments;
fetch(address).then(() => done("read"), () => done("refused"));
"""
FRAME = """
const [address, done] = arguments;
const frame = document.createElement("iframe");
frame.onload = () => done(frame.contentDocument === null ? "foreign" : "empty");
frame.src = address;
document.body.append(frame);
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with chromium(tmp_path_factory.mktemp("profile"), 900, 700) as opened:
        opened.set_script_timeout(PATIENCE)
        yield opened


@pytest.fixture(
    scope="module",
    params=["127.0.0.1", pytest.param("0.0.0.0", marks=pytest.mark.slow)],
)
def served(request: pytest.FixtureRequest) -> Iterator[Served]:
    opened = open_server(request.param, 0)
    heading(opened.server, TITLE)
    port = opened.server.get_port()
    # The browser of these tests looks no name up.
    path = opened.url.split("/", 3)[3]
    yield opened._replace(url=f"http://127.0.0.1:{port}/{path}")
    close(opened.server)


@pytest.fixture(scope="module")
def foreign_page() -> Iterator[str]:
    """The address of a page at another port, which is another origin."""

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<title>foreign</title><body></body>")

        def log_message(self, format: str, *args: Any) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


def websocket(url: str) -> tuple[str, str]:
    return url.replace("http://", "ws://"), f"viser-v{viser.__version__}"


def until(condition: Any) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.1)


def shows_title(browser: Any) -> bool:
    return TITLE in browser.find_element(By.TAG_NAME, "body").text


def test_its_own_page_is_shown(browser: Any, served: Served):
    browser.get(served.url)
    until(lambda: shows_title(browser))
    assert browser.execute_async_script(CONNECT, *websocket(served.url)) == "read"
    errors = [e for e in browser.get_log("browser") if e["level"] == "SEVERE"]
    assert errors == []
    # With what viser's page has made of its address.
    browser.refresh()
    until(lambda: shows_title(browser))


def test_a_foreign_page_is_refused(browser: Any, served: Served, foreign_page: str):
    browser.get(foreign_page)
    assert browser.execute_async_script(CONNECT, *websocket(served.url)) == "refused"
    assert browser.execute_async_script(FETCH, served.url) == "refused"


def test_a_foreign_page_cannot_hold_it(browser: Any, served: Served, foreign_page: str):
    browser.get(foreign_page)
    browser.get_log("browser")
    browser.execute_async_script(FRAME, served.url)
    browser.switch_to.frame(0)
    assert not shows_title(browser)
    browser.switch_to.default_content()
    said = "".join(entry["message"] for entry in browser.get_log("browser"))
    assert "frame-ancestors" in said


def test_its_address_cannot_lead_the_page_to_another_server(
    browser: Any, served: Served
):
    browser.get("about:blank")
    browser.get_log("browser")
    browser.get(f"{served.url}?websocket=ws://127.0.0.1:9")
    said: list[str] = []

    def refused() -> bool:
        said.extend(entry["message"] for entry in browser.get_log("browser"))
        return "connect-src" in "".join(said)

    until(refused)
    assert "ERR_CONNECTION_REFUSED" not in "".join(said)
