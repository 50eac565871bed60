"""The server behind the page, and who may talk to it; viser's one import.

Pages of its own address may, and nobody without the token. A browser lets every page
that is open in it send requests to this machine. It says in `Origin` which page asks,
and in `Host` by which name it was led here; a page cannot change either.
"""

import asyncio
import errno
import ipaddress
import logging
import os
import secrets
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple, Protocol, runtime_checkable

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.text import reason_of

LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "[::1]"})
TOKEN_BYTES = 16
"""128 random bits cannot be guessed."""
HTTP_PORT = 80
"""The port that a browser leaves out of `Host` and `Origin`."""

REFUSED = (
    "Refused: this viewer answers only pages of its own address. Open the address that "
    "orbident has printed, with its port and token.\n"
)

SILENT = logging.getLogger("orbident.viewer")
"""What a stranger sends is no error of the user: nothing is written about it."""
SILENT.disabled = True


@dataclass(frozen=True)
class Gate:
    """Decides which requests reach the viewer."""

    names: frozenset[str]
    """Names by which `Host` may call the viewer; empty where any name is good."""
    token: str
    """Must begin the path; empty where only this machine can connect."""

    @classmethod
    def at(cls, host: str, bound: str) -> "Gate":
        """The gate of a viewer that listens there.

        The host, as the user gave it, means the numeric address that is bound.
        """
        address = ipaddress.ip_address(bound)
        if address.is_unspecified:
            # Any name of this machine leads here, and no list of them is complete. A
            # foreign page that is led here under its own name still lacks the token.
            names = frozenset()
        else:
            names = frozenset({in_address(host).lower(), in_address(bound)})
        if address.is_loopback:
            return cls(names | LOOPBACK_NAMES, "")
        return cls(names, secrets.token_urlsafe(TOKEN_BYTES))

    @property
    def is_open(self) -> bool:
        """Whether other machines can connect."""
        return bool(self.token)

    @property
    def path(self) -> str:
        """The path of the page."""
        return f"/{self.token}/" if self.token else "/"

    def admits(
        self, port: int, hosts: Sequence[str], origins: Sequence[str], plain: bool
    ) -> bool:
        """Whether a request comes from a page of this viewer, or leads to one.

        `Host` must be one of the names with the port. `Origin` must be the same
        address; only a plain request for the page may come without it. All `Host` and
        `Origin` headers are given. A plain request asks for a page, not for a
        websocket.
        """
        if len(hosts) != 1 or not self._is_called(hosts[0].lower(), port):
            return False
        if plain and not origins:
            return True
        return [each.lower() for each in origins] == [f"http://{hosts[0].lower()}"]

    def _is_called(self, host: str, port: int) -> bool:
        name, colon, given = host.rpartition(":")
        if not colon or host.endswith("]"):
            name, given = host, str(HTTP_PORT)
        return given == str(port) and (not self.names or name in self.names)

    def without_token(self, path: str) -> str | None:
        """The path behind the token; None where the token is not the right one."""
        if not self.token:
            return path
        prefix = f"/{self.token}"
        start, rest = path[: len(prefix)], path[len(prefix) :]
        same = secrets.compare_digest(
            start.encode(errors="surrogateescape"), prefix.encode()
        )
        if not same or (rest and rest[0] not in "/?"):
            return None
        return rest if rest.startswith("/") else f"/{rest}"


def in_address(host: str) -> str:
    """A host as it stands in an address: IPv6 in brackets."""
    return f"[{host}]" if ":" in host else host


@contextmanager
def gated(gate: Gate) -> Iterator[Event]:
    """Put the gate before every websockets server that is made meanwhile.

    viser has no argument for it, but makes its server by
    `websockets.asyncio.server.serve`, of which `process_request` and `logger` are
    documented arguments. The caller must check that it did: the event is set then.
    """
    # Late: websockets comes with the extra `view`.
    from unittest.mock import patch

    import websockets.asyncio.server as servers

    plain, done = servers.serve, Event()

    def serve(*arguments: Any, process_request: Any, **options: Any) -> Any:
        done.set()
        # What a client sends is handled in tasks of this loop.
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: None)
        checked = _checked(gate, process_request)
        return plain(*arguments, process_request=checked, logger=SILENT, **options)

    with patch.object(servers, "serve", serve):
        yield done


def _checked(gate: Gate, answer: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """The same answers, to those only whom the gate admits."""

    def checked(connection: Any, request: Any) -> Any:
        path = gate.without_token(request.path)
        headers = request.headers
        admitted = gate.admits(
            connection.local_address[1],
            headers.get_all("Host"),
            headers.get_all("Origin"),
            plain=not headers.get_all("Upgrade"),
        )
        if path is None or not admitted:
            return connection.respond(403, REFUSED)
        response = answer(connection, replace(request, path=path))
        if response is not None:
            for name, value in restrictions(headers["Host"]).items():
                response.headers[name] = value
        return response

    return checked


def restrictions(host: str) -> dict[str, str]:
    """Headers that keep the page from being used by another one.

    No page may hold it in a frame, where a click could be led onto it. It may connect
    to nothing but this server: viser's page takes a server's address from its own
    (`?websocket=`), and a server can run programs in the page.
    """
    sources = f"'self' ws://{host} data: blob:"
    return {
        "Content-Security-Policy": f"connect-src {sources}; frame-ancestors 'none'",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Frame-Options": "DENY",
    }


PERIOD = 1 / 30
"""Time from one picture to the next, s."""


@runtime_checkable
class Page(Protocol):
    """What is shown, and moves by itself."""

    def advance(self, seconds: float) -> None:
        """Let so much time pass."""
        ...


class Served(NamedTuple):
    """An empty page in the browser."""

    server: Any
    """viser's."""
    url: str
    """Where to point the browser; holds the token where there is one."""
    is_open: bool
    """Whether other machines can connect."""


def open_server(host: str, port: int) -> Served:
    """Serve an empty page to those whom the gate admits.

    The host is an address of this machine, and port 0 any that is free.

    Raises:
        InputError: viser is not installed, the host is no address of this machine, or
            the port is taken or not allowed.
    """
    with extra("view", "the viewer"):
        import viser

    bound = _free(host, port)
    gate = Gate.at(host, bound)
    with _silent(), gated(gate) as served:
        server = viser.ViserServer(bound, port, verbose=False)
    if not served.is_set():
        close(server)
        raise RuntimeError(f"viser {viser.__version__} serves past the gate")
    # What casts shadows takes most of the time where there is no graphics card.
    server.scene.configure_default_lights(cast_shadow=False)
    # What the share button makes is a public address elsewhere.
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    # Beside the robot, not before it; on a phone below it.
    server.gui.main_panel.dock_right()
    name = in_address(host if gate.names else socket.gethostname())
    url = f"http://{name}:{server.get_port()}{gate.path}"
    return Served(server, url, gate.is_open)


def keep_moving(page: Page) -> None:
    """Let the page move until the process is interrupted."""
    before = time.monotonic()
    with _silent():
        while True:
            time.sleep(PERIOD)
            now = time.monotonic()
            page.advance(now - before)
            before = now


def close(server: Any) -> None:
    """Stop serving."""
    with _silent():
        server.stop()


@contextmanager
def _silent() -> Iterator[None]:
    """Standard output is for results, and viser writes there too."""
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
        yield


def _free(host: str, port: int) -> str:
    """The numeric address that the host means, once it is known that it can be used."""
    # viser would silently take the next port, and any failure for a taken one.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
            return probe.getsockname()[0]
        except (socket.gaierror, UnicodeError):
            raise InputError(
                f"--host: found '{host}'; give an address of this machine, such as "
                "127.0.0.1, or 0.0.0.0 for all of them"
            ) from None
        except OSError as error:
            if error.errno == errno.EADDRNOTAVAIL:
                raise InputError(
                    f"--host: '{host}' is no address of this machine; give 127.0.0.1, "
                    "or 0.0.0.0 for all of them"
                ) from None
            raise InputError(
                f"--port: {port} at {host} cannot be used ({reason_of(error)}); give "
                "another, or 0 for any that is free"
            ) from None
