"""Estimates as they come, in the browser: one page, and server-sent events."""

import json
import sys
import threading
from collections import deque
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from orbident.viewer.server import REFUSED, Gate, restrictions

HOST = "127.0.0.1"
"""Only browsers of this machine can connect."""

PAGE = Path(__file__).with_name("live.html")

KEPT = 600
"""Events that a page which is opened later is still shown: ten minutes of one a
second."""

ALIVE = 10.0
"""s: so often a word is sent when nothing happens, which finds pages that are gone."""


class LivePage:
    """Serves the page until it is closed."""

    def __init__(self, first: dict[str, Any]) -> None:
        """Listen at a free port. Every page is first told names and beliefs."""
        self._first = json.dumps(first)
        self._events: deque[str] = deque(maxlen=KEPT)
        self._sent = 0
        self._news = threading.Condition()
        self._closed = False
        page, gate = self, Gate.at(HOST, HOST)

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                page._answer(self, gate)

            def log_message(self, format: str, *args: Any) -> None:
                """What a stranger sends is no error of the user."""

        self._server = _Server((HOST, 0), Handler)
        self.url = f"http://{HOST}:{self._server.server_port}/"
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def send(self, document: dict[str, Any]) -> None:
        """Show it on every page."""
        with self._news:
            self._events.append(json.dumps(document))
            self._sent += 1
            self._news.notify_all()

    def close(self) -> None:
        """Serve no longer."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def _answer(self, request: BaseHTTPRequestHandler, gate: Gate) -> None:
        hosts = request.headers.get_all("Host") or []
        origins = request.headers.get_all("Origin") or []
        if not gate.admits(self._server.server_port, hosts, origins, plain=True):
            _respond(request, 403, "text/plain", REFUSED.encode())
        elif request.path == "/":
            _respond(request, 200, "text/html; charset=utf-8", PAGE.read_bytes())
        elif request.path == "/events":
            self._stream(request)
        else:
            _respond(request, 404, "text/plain", b"There is no such page.\n")

    def _stream(self, request: BaseHTTPRequestHandler) -> None:
        """All that was kept, then what comes, until the reader goes."""
        request.send_response(200)
        _send_headers(request, "text/event-stream")
        try:
            request.wfile.write(f"data: {self._first}\n\n".encode())
            seen = 0
            while not self._closed:
                with self._news:
                    if seen == self._sent:
                        self._news.wait(ALIVE)
                    missed = min(self._sent - seen, len(self._events))
                    new = list(self._events)[len(self._events) - missed :]
                    seen = self._sent
                text = "".join(f"data: {event}\n\n" for event in new) or ": alive\n\n"
                request.wfile.write(text.encode())
                request.wfile.flush()
        except OSError:
            return


class _Server(ThreadingHTTPServer):
    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that hangs up is no error; anything else is one of ours."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


def _respond(
    request: BaseHTTPRequestHandler, status: int, kind: str, content: bytes
) -> None:
    request.send_response(status)
    _send_headers(request, kind, len(content))
    request.wfile.write(content)


def _send_headers(
    request: BaseHTTPRequestHandler, kind: str, length: int | None = None
) -> None:
    request.send_header("Content-Type", kind)
    request.send_header("Cache-Control", "no-store")
    if length is not None:
        request.send_header("Content-Length", str(length))
    for name, value in restrictions(request.headers.get("Host", "")).items():
        request.send_header(name, value)
    request.end_headers()
